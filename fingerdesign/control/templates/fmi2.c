/* What units of FMI 2.0 for co-simulation have in common. The unit's file defines GUID, REALS, INTEGERS,
   BOOLEANS, which of them are outputs, and a struct ``unit`` with their values; then it includes this
   file, and defines the seven functions declared here. A state is a copy of the struct. */

#include <stddef.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>

#if defined(_WIN32)
#define EXPORT __declspec(dllexport)
#else
#define EXPORT __attribute__((visibility("default")))
#endif

enum { OK, WARNING, DISCARD, ERROR };

typedef unsigned int reference;
typedef void logger(void *, const char *, int, const char *, const char *, ...);
typedef struct {
    logger *log;
    void *allocate, *release, *finished, *environment;
} callback_functions;

static int unit_loads(const char *uri); /* the resources of this folder; 0: it does not hold them */
static int unit_opens(unit *u);         /* memory of one instance; 0: there is none */
static void unit_closes(unit *u);
static void unit_resets(unit *u);             /* values as described */
static int unit_starts(unit *u);              /* with the parameters given: OK or ERROR */
static int unit_steps(unit *u, double step);  /* s: OK or ERROR */

/* Hands a reason, without a %, to the simulator; ERROR. */
static int says(const unit *u, const char *message) {
    const callback_functions *given = u->callbacks;
    if (given != NULL && given->log != NULL)
        given->log(given->environment, "unit", ERROR, "logStatusError", message);
    return ERROR;
}

/* Reads a file of so many bytes in the folder that a file URI names; 0 where it is not there. */
static int reads_file(const char *uri, const char *name, unsigned char *bytes, size_t size) {
    char path[4096];
    size_t n = 0;
    unsigned int code;
    FILE *file;
    if (uri == NULL || strncmp(uri, "file:", 5) != 0)
        return 0;
    for (uri += strncmp(uri, "file://", 7) ? 5 : 7; *uri && n + 64 < sizeof path; uri++)
        if (*uri == '%' && sscanf(uri + 1, "%2x", &code) == 1) {
            path[n++] = (char)code;
            uri += 2;
        } else
            path[n++] = *uri;
    snprintf(path + n, sizeof path - n, "/%s", name);
    file = fopen(path + (path[0] == '/' && path[2] == ':'), "rb"); /* /C:/... */
    if (file == NULL)
        return 0;
    n = fread(bytes, 1, size, file);
    fclose(file);
    return n == size;
}

EXPORT const char *fmi2GetTypesPlatform(void) { return "default"; }
EXPORT const char *fmi2GetVersion(void) { return "2.0"; }

EXPORT void *fmi2Instantiate(const char *name, int type, const char *guid, const char *resources,
                             const void *callbacks, int visible, int logging) {
    unit *u;
    (void)name, (void)visible, (void)logging;
    if (type != 1 || guid == NULL || strcmp(guid, GUID) != 0 || !unit_loads(resources))
        return NULL; /* 1: co-simulation */
    u = calloc(1, sizeof *u);
    if (u == NULL)
        return NULL;
    u->callbacks = callbacks;
    if (!unit_opens(u)) {
        free(u);
        return NULL;
    }
    unit_resets(u);
    return u;
}

EXPORT void fmi2FreeInstance(void *u) {
    if (u != NULL)
        unit_closes(u);
    free(u);
}

EXPORT int fmi2SetDebugLogging(void *u, int on, size_t count, const char *const names[]) {
    return (void)u, (void)on, (void)count, (void)names, OK;
}
EXPORT int fmi2SetupExperiment(void *u, int tolerant, double tolerance, double start, int ends,
                               double stop) {
    return (void)u, (void)tolerant, (void)tolerance, (void)start, (void)ends, (void)stop, OK;
}
EXPORT int fmi2EnterInitializationMode(void *u) { return (void)u, OK; }
EXPORT int fmi2ExitInitializationMode(void *u) { return unit_starts(u); }
EXPORT int fmi2Terminate(void *u) { return (void)u, OK; }
EXPORT int fmi2Reset(void *u) { return unit_resets(u), OK; }

#define ACCESS(Kind, type, values, count_of, is_output)                                            \
    EXPORT int fmi2Get##Kind(void *c, const reference at[], size_t count, type value[]) {          \
        for (size_t k = 0; k < count; k++) {                                                       \
            if (at[k] >= count_of)                                                                 \
                return ERROR;                                                                      \
            value[k] = ((unit *)c)->values[at[k]];                                                 \
        }                                                                                          \
        return OK;                                                                                 \
    }                                                                                              \
    EXPORT int fmi2Set##Kind(void *c, const reference at[], size_t count, const type value[]) {    \
        for (size_t k = 0; k < count; k++) {                                                       \
            if (at[k] >= count_of || is_output(at[k]))                                             \
                return ERROR;                                                                      \
            ((unit *)c)->values[at[k]] = value[k];                                                 \
        }                                                                                          \
        return OK;                                                                                 \
    }

ACCESS(Real, double, real, REALS, REAL_OUT)
ACCESS(Integer, int, integer, INTEGERS, INTEGER_OUT)
ACCESS(Boolean, int, boolean, BOOLEANS, BOOLEAN_OUT)

EXPORT int fmi2GetString(void *c, const reference at[], size_t count, const char *value[]) {
    return (void)c, (void)at, (void)value, count ? ERROR : OK;
}
EXPORT int fmi2SetString(void *c, const reference at[], size_t count, const char *const value[]) {
    return (void)c, (void)at, (void)value, count ? ERROR : OK;
}

EXPORT int fmi2DoStep(void *c, double now, double step, int final) {
    return (void)now, (void)final, unit_steps(c, step);
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
