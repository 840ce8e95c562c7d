/* Steps of the regulator on a bare Cortex-M in an emulator: what each answers, and the stack it took.
   samples.h: the curves, and SAMPLES of a grip, outside the flash that is counted. */

#include "regulator.h"
#include "samples.h"

#include <stdint.h>
#include <string.h>

extern uint32_t stack_top, bss_start, bss_end;
int main(void);
void reset(void);

__attribute__((section(".vectors"), used)) static const void *const VECTORS[2] = {&stack_top,
                                                                                  (void *)reset};

static regulator hand;

/* Semihosting: 4 writes a text, 0x18 ends. */
static void host(int what, const void *with) {
    register int r0 __asm__("r0") = what;
    register const void *r1 __asm__("r1") = with;
    __asm__ volatile("bkpt 0xab" : "+r"(r0) : "r"(r1) : "memory");
}

static void writes(uint32_t value, char end) {
    char text[10];
    int k;
    for (k = 0; k < 8; k++)
        text[k] = "0123456789abcdef"[value >> (28 - 4 * k) & 15];
    text[8] = end;
    text[9] = 0;
    host(4, text);
}

void reset(void) {
    volatile uint32_t *own = &bss_end, *sp;
    *(volatile uint32_t *)0xE000ED88 |= 0xF << 20; /* the floating-point unit */
    __asm__ volatile("dsb\nisb\nmov %0, sp" : "=r"(sp));
    memset(&bss_start, 0, (size_t)((char *)&bss_end - (char *)&bss_start));
    while (own < sp - 16)
        *own++ = 0xA5A5A5A5;
    main();
    own = &bss_end;
    while (*own == 0xA5A5A5A5)
        own++;
    writes((uint32_t)((char *)&stack_top - (char *)own), '\n');
    host(0x18, (void *)0x20026);
}

int main(void) {
    int k, i;
    if (regulator_init(&hand, &CURVES, DELAY, STIFFNESS))
        return 1;
    for (k = 0; k < SAMPLES; k++) {
        uint32_t bits[5];
        regulator_command next;
        const float *at = SAMPLE[k];
        regulator_step(&hand, at + 2, at[0], at[1], 0, &next);
        memcpy(bits, &next, sizeof bits);
        for (i = 0; i < 5; i++)
            writes(bits[i], i < 4 ? ' ' : '\n');
    }
    return 0;
}
