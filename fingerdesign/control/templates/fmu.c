/* The regulator as a functional mock-up unit, FMI 2.0 for co-simulation: one step of the unit is one
   sample of the hand. Compile this file alone (-std=c99 -shared -fPIC -lm); it includes the others.
   Its network's weights are in resources/weights.bin: all high bytes, then all low ones.

   Reals: the readings, F_n, F_t, torque (inputs); dx, dy, stick_ratio, used, friction (outputs);
   stiffness, cross_talk (parameters). Integers: delay. Booleans: lifted (input); unsure, missed (outputs). */

#include "regulator.c"

#define GUID "@guid@"
#define PERIOD @period@
#define CURVE_POINTS @points@
#define REALS (GAGES + 10)
#define INTEGERS 1
#define BOOLEANS 3
#define REAL_OUT(k) ((k) >= DX && (k) <= FRICTION)
#define INTEGER_OUT(k) 0
#define BOOLEAN_OUT(k) ((k) != LIFTED)

enum { LIFTED, UNSURE, MISSED };
enum {
    NORMAL = GAGES,
    TANGENTIAL,
    TORQUE,
    DX,
    DY,
    STICK_RATIO,
    USED,
    FRICTION,
    STIFFNESS,
    CROSS_TALK
};

@curves@

typedef struct {
    double real[REALS];
    int integer[INTEGERS], boolean[BOOLEANS];
    const void *callbacks;
    regulator hand;
} unit;

#include "fmi2.c"

static int unit_loads(const char *uri) {
    static unsigned char bytes[2 * COUNT(WEIGHTS)];
    size_t k;
    if (!reads_file(uri, "weights.bin", bytes, sizeof bytes))
        return 0;
    for (k = 0; k < COUNT(WEIGHTS); k++)
        WEIGHTS[k] = (int16_t)(bytes[k] << 8 | bytes[COUNT(WEIGHTS) + k]);
    return 1;
}

static int unit_opens(unit *u) { return (void)u, 1; }
static void unit_closes(unit *u) { (void)u; }

static void unit_resets(unit *u) {
    memset(u, 0, offsetof(unit, callbacks));
    u->real[STIFFNESS] = @stiffness@;
}

static int unit_starts(unit *u) {
    regulator_curves curves = {CURVE_POINTS,   CURVE_FORCE,     CURVE_PRESSED, CURVE_STICKING,
                               CURVE_APPROACH, CURVE_STIFFNESS, 0.0f,          CURVE_TURN_RADIUS};
    curves.cross_talk = (float)u->real[CROSS_TALK];
    memset(&u->hand, 0, sizeof u->hand);
    if (regulator_init(&u->hand, &curves, u->integer[0], (float)u->real[STIFFNESS]))
        return says(u, "delay must be 0 to 120, stiffness over 0 and finite, cross_talk finite");
    return OK;
}

/* Of any other step than one sample's there is none. */
static int unit_steps(unit *u, double step) {
    regulator_command next_move;
    float readings[GAGES];
    int k;
    if (!(step > 0.999 * PERIOD && step < 1.001 * PERIOD))
        return says(u, "the step must be one sample of the hand, @period@ s");
    for (k = 0; k < GAGES; k++)
        readings[k] = (float)u->real[k];
    regulator_torque(&u->hand, (float)u->real[TORQUE]);
    u->boolean[MISSED] =
        regulator_step(&u->hand, readings, (float)u->real[NORMAL], (float)u->real[TANGENTIAL],
                       u->boolean[LIFTED], &next_move);
    u->real[DX] = next_move.dx;
    u->real[DY] = next_move.dy;
    u->real[STICK_RATIO] = next_move.stick_ratio;
    u->real[USED] = next_move.used;
    u->real[FRICTION] = next_move.friction;
    u->boolean[UNSURE] = next_move.unsure;
    return OK;
}
