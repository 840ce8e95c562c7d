/* The regulator as a functional mock-up unit, FMI 2.0 for co-simulation: one step of the unit is one
   sample of the hand. Compile this file alone (-std=c99 -shared -fPIC -lm); it includes regulator.c.
   Its network's weights are in resources/weights.bin: all high bytes, then all low ones.

   Reals: the readings, F_n, F_t (inputs); dx, dy, stick_ratio, used, friction (outputs); stiffness,
   cross_talk (parameters). Integers: delay. Booleans: lifted (input); unsure, missed (outputs). */

#include "regulator.c"

#include <stdio.h>
#include <stdlib.h>

#define GUID "@guid@"
#define PERIOD @period@
#define CURVE_POINTS @points@
#define REALS (GAGES + 9)
#define BOOLEANS 3

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT
#endif

enum { OK, WARNING, DISCARD, ERROR };
enum { LIFTED, UNSURE, MISSED };
enum { NORMAL = GAGES, TANGENTIAL, DX, DY, STICK_RATIO, USED, FRICTION, STIFFNESS, CROSS_TALK };

@curves@

typedef struct {
    regulator hand;
    double real[REALS];
    int boolean[BOOLEANS], delay;
} unit;

typedef unsigned int reference;

static int starts(unit *u) {
    regulator_curves curves = {CURVE_POINTS,    CURVE_FORCE,     CURVE_PRESSED, CURVE_STICKING,
                               CURVE_APPROACH, CURVE_STIFFNESS, 0.0f};
    curves.cross_talk = (float)u->real[CROSS_TALK];
    return regulator_init(&u->hand, &curves, u->delay, (float)u->real[STIFFNESS]);
}

static void reset(unit *u) {
    memset(u, 0, sizeof *u);
    u->real[STIFFNESS] = @stiffness@;
}

/* Fills WEIGHTS from the folder that a file URI names; 0 where it holds none. */
static int reads_weights(const char *uri) {
    char path[4096];
    static unsigned char bytes[2 * COUNT(WEIGHTS)];
    size_t n = 0, k;
    unsigned int code;
    FILE *file;
    if (uri == NULL || strncmp(uri, "file:", 5) != 0)
        return 0;
    for (uri += strncmp(uri, "file://", 7) ? 5 : 7; *uri && n + 16 < sizeof path; uri++)
        if (*uri == '%' && sscanf(uri + 1, "%2x", &code) == 1) {
            path[n++] = (char)code;
            uri += 2;
        } else
            path[n++] = *uri;
    strcpy(path + n, "/weights.bin");
    file = fopen(path + (path[0] == '/' && path[2] == ':'), "rb"); /* /C:/... */
    if (file == NULL)
        return 0;
    n = fread(bytes, 1, sizeof bytes, file);
    fclose(file);
    for (k = 0; k < COUNT(WEIGHTS); k++)
        WEIGHTS[k] = (int16_t)(bytes[k] << 8 | bytes[COUNT(WEIGHTS) + k]);
    return n == sizeof bytes;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                             const void *callbacks, int visible, int logging) {
    unit *u;
    (void)name, (void)callbacks, (void)visible, (void)logging;
    if (type != 1 || guid == NULL || strcmp(guid, GUID) != 0 || !reads_weights(resources))
        return NULL; /* 1: co-simulation */
    u = malloc(sizeof *u);
    if (u != NULL)
        reset(u);
    return u;
}

EXPORT void fmi2FreeInstance(void *u) { free(u); }

EXPORT int fmi2SetDebugLogging(void *u, int on, size_t count, const char *const names[]) {
    (void)u, (void)on, (void)count, (void)names;
    return OK;
}

EXPORT int fmi2SetupExperiment(void *u, int tolerant, double tolerance, double start, int ends,
                               double stop) {
    (void)u, (void)tolerant, (void)tolerance, (void)start, (void)ends, (void)stop;
    return OK;
}

EXPORT int fmi2EnterInitializationMode(void *u) {
    (void)u;
    return OK;
}

EXPORT int fmi2ExitInitializationMode(void *u) { return starts(u) ? ERROR : OK; }

EXPORT int fmi2Terminate(void *u) {
    (void)u;
    return OK;
}

EXPORT int fmi2Reset(void *u) {
    reset(u);
    return OK;
}

EXPORT int fmi2GetReal(void *c, const reference at[], size_t count, double value[]) {
    for (size_t k = 0; k < count; k++) {
        if (at[k] >= REALS)
            return ERROR;
        value[k] = ((unit *)c)->real[at[k]];
    }
    return OK;
}

EXPORT int fmi2SetReal(void *c, const reference at[], size_t count, const double value[]) {
    for (size_t k = 0; k < count; k++) {
        if (at[k] >= REALS || (at[k] >= DX && at[k] <= FRICTION))
            return ERROR;
        ((unit *)c)->real[at[k]] = value[k];
    }
    return OK;
}

EXPORT int fmi2GetInteger(void *c, const reference at[], size_t count, int value[]) {
    for (size_t k = 0; k < count; k++) {
        if (at[k] != 0)
            return ERROR;
        value[k] = ((unit *)c)->delay;
    }
    return OK;
}

EXPORT int fmi2SetInteger(void *c, const reference at[], size_t count, const int value[]) {
    for (size_t k = 0; k < count; k++) {
        if (at[k] != 0)
            return ERROR;
        ((unit *)c)->delay = value[k];
    }
    return OK;
}

EXPORT int fmi2GetBoolean(void *c, const reference at[], size_t count, int value[]) {
    for (size_t k = 0; k < count; k++) {
        if (at[k] >= BOOLEANS)
            return ERROR;
        value[k] = ((unit *)c)->boolean[at[k]];
    }
    return OK;
}

EXPORT int fmi2SetBoolean(void *c, const reference at[], size_t count, const int value[]) {
    for (size_t k = 0; k < count; k++) {
        if (at[k] != LIFTED)
            return ERROR;
        ((unit *)c)->boolean[LIFTED] = value[k] != 0;
    }
    return OK;
}

EXPORT int fmi2GetString(void *c, const reference at[], size_t count, const char *value[]) {
    (void)c, (void)at, (void)value;
    return count ? ERROR : OK;
}

EXPORT int fmi2SetString(void *c, const reference at[], size_t count, const char *const value[]) {
    (void)c, (void)at, (void)value;
    return count ? ERROR : OK;
}

/* Of any other step than one sample's there is none. */
EXPORT int fmi2DoStep(void *c, double now, double step, int final) {
    unit *u = c;
    regulator_command next_move;
    float readings[GAGES];
    int k;
    (void)now, (void)final;
    if (!(step > 0.999 * PERIOD && step < 1.001 * PERIOD))
        return ERROR;
    for (k = 0; k < GAGES; k++)
        readings[k] = (float)u->real[k];
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

EXPORT int fmi2GetFMUstate(void *c, void **state) {
    if (*state == NULL && (*state = malloc(sizeof(unit))) == NULL)
        return ERROR;
    memcpy(*state, c, sizeof(unit));
    return OK;
}

EXPORT int fmi2SetFMUstate(void *c, void *state) {
    memcpy(c, state, sizeof(unit));
    return OK;
}

EXPORT int fmi2FreeFMUstate(void *c, void **state) {
    (void)c;
    free(*state);
    *state = NULL;
    return OK;
}

/* What the description does not offer. */
EXPORT int fmi2SerializedFMUstateSize(void *c, void *s, size_t *n) {
    return (void)c, (void)s, (void)n, ERROR;
}
EXPORT int fmi2SerializeFMUstate(void *c, void *s, char *to, size_t n) {
    return (void)c, (void)s, (void)to, (void)n, ERROR;
}
EXPORT int fmi2DeSerializeFMUstate(void *c, const char *from, size_t n, void **s) {
    return (void)c, (void)from, (void)n, (void)s, ERROR;
}
EXPORT int fmi2GetDirectionalDerivative(void *c, const reference of[], size_t m,
                                        const reference by[], size_t n, const double d[],
                                        double to[]) {
    return (void)c, (void)of, (void)m, (void)by, (void)n, (void)d, (void)to, ERROR;
}
EXPORT int fmi2SetRealInputDerivatives(void *c, const reference at[], size_t n, const int order[],
                                       const double value[]) {
    return (void)c, (void)at, (void)n, (void)order, (void)value, ERROR;
}
EXPORT int fmi2GetRealOutputDerivatives(void *c, const reference at[], size_t n, const int order[],
                                        double value[]) {
    return (void)c, (void)at, (void)n, (void)order, (void)value, ERROR;
}
EXPORT int fmi2CancelStep(void *c) { return (void)c, ERROR; }
EXPORT int fmi2GetStatus(void *c, int kind, int *v) { return (void)c, (void)kind, (void)v, DISCARD; }
EXPORT int fmi2GetRealStatus(void *c, int kind, double *v) {
    return (void)c, (void)kind, (void)v, DISCARD;
}
EXPORT int fmi2GetIntegerStatus(void *c, int kind, int *v) {
    return (void)c, (void)kind, (void)v, DISCARD;
}
EXPORT int fmi2GetBooleanStatus(void *c, int kind, int *v) {
    return (void)c, (void)kind, (void)v, DISCARD;
}
EXPORT int fmi2GetStringStatus(void *c, int kind, const char **v) {
    return (void)c, (void)kind, (void)v, DISCARD;
}
