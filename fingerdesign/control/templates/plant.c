/* A finger against a rigid plane as a functional mock-up unit, FMI 2.0 for co-simulation: one step of the
   unit, of any length, is one move of the object by (dx, dy). Compile this file alone (-std=c99 -O3
   -shared -fPIC -lm); it includes the others.

   The condensed model of @design@ with its friction history. kernel.c is the simulation's own:
   it follows an increment from the last one and writes its certificate. An answer that breaks a law by
   more than ACCEPT is none: the step is then an error, and nothing has changed. Numbers are in
   resources/model.bin: doubles, all first bytes, all second ones, and so on, the highest first.

   Reals: dx, dy (inputs); the readings, F_n, F_t, approach, shear (outputs); friction, object_mass
   (parameters). Integers: touching, sticking nodes. Booleans: lifted. */

#include "dense.c"
#include "kernel.c"

#define GUID "@guid@"
#define NODES @nodes@
#define DIM @dim@
#define GAGES @gages@
#define N (NODES * DIM)
#define REALS (GAGES + 8)
#define INTEGERS 2
#define BOOLEANS 1
#define REAL_OUT(k) ((k) >= READING && (k) < FRICTION)
#define INTEGER_OUT(k) 1
#define BOOLEAN_OUT(k) 1

enum { DX, DY, READING, NORMAL = READING + GAGES, TANGENTIAL, APPROACH, SHEAR, FRICTION, MASS };

static const double TYPICAL = @typical@;   /* mm/N: a node's own normal compliance, the median */
static const double HALVES = @symmetry@;   /* of the finger in one modelled part */
static const double FACTOR = 0.5;          /* rho C_ii, as in tracking.py */
static const double ACCEPT = 1e-8, ACCEPT_BALANCE = 1e-6; /* as in increment.py */
static const double ONWARD = 0.9, LONGEST = 1.5;          /* as in tracking.py */
static const double NEWTONS = 0.5e-3 * 9.80665;           /* of a gram, on one of two fingers */
enum { JOIN = 3, GUESSES = 12, MOST_PIECES = 64 }; /* of open nodes; rounds; of a move */
static const unsigned char BALANCED[] = {@balanced@};

/* In the order of the file. The compliance's lower half is; the rest follows when it is read. */
static struct {
    double lower[N * (N + 1) / 2], clearance[NODES], modes[2][N], frames[N * DIM], reaction[DIM * N];
    double readout[GAGES * N], rim[NODES];
} given;
static double compliance[N * N], own[NODES], rho[NODES];
static unsigned char rim[NODES];

/* The last increment, and the history that it left. */
typedef struct {
    double motion[2], change[2], largest;
    double force[N], yielded[N], ahead[N], slip[N - NODES], travelled[NODES], sliding[NODES];
    int64_t status[NODES];
} history;

/* What saves time, and may be lost: the inverse on a base of nodes. */
typedef struct {
    Follower *follower;
    int half; /* of the two inverses and lists, the one at hand */
    int64_t nodes[2][NODES];
    double inverse[2][N * N], answer[3 * N], reals[5 + 3 * N + NODES];
    int64_t codes[2 * NODES];
} scratch;

typedef struct {
    double real[REALS];
    int integer[INTEGERS], boolean[BOOLEANS];
    const void *callbacks;
    scratch *work;
    history past;
} unit;

#include "fmi2.c"

static int unit_loads(const char *uri) {
    enum { COUNT = sizeof given / sizeof(double) };
    static unsigned char bytes[8 * COUNT];
    const double *from = given.lower;
    if (!reads_file(uri, "model.bin", bytes, sizeof bytes))
        return 0;
    for (size_t k = 0; k < COUNT; k++) {
        uint64_t bits = 0;
        for (int b = 0; b < 8; b++)
            bits = bits << 8 | bytes[b * (size_t)COUNT + k];
        memcpy((double *)&given + k, &bits, sizeof bits);
    }
    for (int i = 0; i < N; i++)
        for (int j = 0; j <= i; j++)
            compliance[i * N + j] = compliance[j * N + i] = *from++;
    for (int i = 0; i < NODES; i++) {
        own[i] = compliance[i * DIM * (N + 1)];
        rho[i] = FACTOR / own[i];
        rim[i] = given.rim[i] != 0.0;
    }
    return 1;
}

static int unit_opens(unit *u) {
    static const Law law = {1.0, 0.0, INFINITY, 0.0, 1.0, INFINITY, NULL};
    blas.dsymv = dense_dsymv, blas.dgemv = dense_dgemv, blas.dgemm = dense_dgemm;
    blas.dtrmm = dense_dtrmm, blas.dpotrf = dense_dpotrf, blas.dtrtri = dense_dtrtri;
    blas.dgetrf = dense_dgetrf, blas.sgetrf = dense_sgetrf;
    blas.dgetrs = dense_dgetrs, blas.sgetrs = dense_sgetrs;
    u->work = calloc(1, sizeof *u->work);
    if (u->work != NULL)
        u->work->follower = follower_new(NODES, DIM, &law, TYPICAL, compliance, rho);
    if (u->work != NULL && u->work->follower == NULL) {
        free(u->work);
        u->work = NULL;
    }
    return u->work != NULL;
}

static void unit_closes(unit *u) {
    follower_free(u->work->follower);
    free(u->work);
}

static void unit_resets(unit *u) {
    memset(u, 0, offsetof(unit, callbacks));
    memset(&u->past, 0, sizeof u->past);
    u->real[FRICTION] = @friction@, u->real[MASS] = @mass@;
}

static int unit_starts(unit *u) {
    if (!(u->real[FRICTION] > 0.0 && u->real[FRICTION] <= 5.0 && u->real[MASS] > 0.0))
        return says(u, "friction must be over 0 and at most 5, object_mass over 0");
    return OK;
}

/* Takes nodes into the base, as many at a time as the follower's memory can border; 0: it is singular. */
static int takes_in(scratch *w, const int64_t *joins, int count) {
    Follower *f = w->follower;
    for (int done = 0, part; done < count; done += part) {
        int64_t *nodes = w->nodes[!w->half];
        part = count - done < NODES / 4 + 1 ? count - done : NODES / 4 + 1;
        if (!follower_border(f, joins + done, part, w->inverse[!w->half]))
            return 0;
        for (int i = 0; i < f->k; i++)
            nodes[i] = f->nodes[i];
        memcpy(nodes + f->k, joins + done, part * sizeof *joins);
        w->half = !w->half;
        follower_base(f, f->k + part, nodes, w->inverse[w->half]);
    }
    return 1;
}

/* Brings the base to the nodes needed and the nearest open ones, as tracking.py; 0: it cannot. */
static int brings_base(scratch *w) {
    Follower *f = w->follower;
    int64_t joins[NODES];
    int needed = 0, count = 0;
    for (int i = 0; i < NODES; i++)
        needed += f->needed[i];
    int ring = (int)(RING * needed) > LEAST ? (int)(RING * needed) : LEAST;
    if (f->k > 0 && f->k - needed <= WIDEST * ring)
        ring = JOIN;
    else
        follower_base(f, 0, NULL, NULL);
    for (int i = 0; i < NODES; i++)
        if (f->needed[i] && !f->inside[i])
            joins[count++] = i;
    for (int k = 0; k < ring; k++) {
        int nearest = -1;
        for (int i = 0; i < NODES; i++)
            if (!f->needed[i] && !f->inside[i] && (nearest < 0 || f->gap[i] < f->gap[nearest]))
                nearest = i;
        if (nearest < 0)
            break;
        f->needed[nearest] = 1;
        joins[count++] = nearest;
    }
    return takes_in(w, joins, count);
}

/* Follows an increment to ``offset``, the answer into work; turned and share: as in kernel.c. */
static int follows(scratch *w, const history *from, const double *offset, int turned, double share) {
    double *out = w->answer;
    if (!(from->largest > 0.0))
        return 0;
    int came = follower_begin(w->follower, offset, from->force, from->yielded, from->status,
                              from->ahead, from->largest, turned, 0, share, out, out + N, out + 2 * N);
    while (came == NEEDS_A_BASE) {
        if (!brings_base(w))
            return 0;
        came = follower_go(w->follower, 1);
    }
    return came == FOUND;
}

/* Lets ``to`` begin from its forces alone: made admissible, what they yield, statuses by their limits. */
static void begins(history *to, double friction) {
    memset(to->yielded, 0, sizeof to->yielded);
    memset(to->ahead, 0, sizeof to->ahead);
    to->largest = 0.0;
    for (int i = 0; i < NODES; i++) {
        double *force = to->force + i * DIM, bound = friction * force[0];
        double size = length_of(force + 1, DIM - 1);
        for (int a = 1; a < DIM && size > bound; a++)
            force[a] *= bound / size;
        to->largest = fmax(to->largest, force[0]);
        to->status[i] = force[0] > 0.0 ? (size >= bound * (1.0 - 1e-9) ? SLIP : STICK) : OPEN;
    }
    add_product(1.0, compliance, N, to->force, to->yielded);
}

/* Normal forces that close the gap under the tangential ones at hand, by an active set (guess.py). */
static void presses(scratch *w, const double *offset, history *to) {
    double *gap = w->reals, *right = gap + NODES, *pulled = w->answer, *matrix = w->follower->work;
    int closed[NODES], next[NODES], list[NODES], any = 0, count = 0, changes = 1, info;
    for (int i = 0; i < NODES; i++) {
        any |= closed[i] = to->force[i * DIM] > 0.0;
        to->force[i * DIM] = 0.0;
    }
    memset(pulled, 0, N * sizeof(double));
    add_product(1.0, compliance, N, to->force, pulled);
    for (int i = 0; i < NODES; i++) {
        gap[i] = offset[i * DIM] + pulled[i * DIM];
        closed[i] = any ? closed[i] : gap[i] < 0.0;
    }
    for (int round = 0; round < GUESSES && changes; round++) {
        changes = count = 0;
        for (int i = 0; i < NODES; i++)
            if (closed[i])
                right[count] = -gap[i], list[count++] = i;
        for (int a = 0; a < count; a++)
            for (int b = 0; b < count; b++)
                matrix[b + a * count] = compliance[list[a] * DIM * N + list[b] * DIM];
        dense_dgetrf(&count, &count, matrix, &count, w->follower->pivots, &info);
        if (info)
            return;
        dense_dgetrs("T", &count, NULL, matrix, &count, w->follower->pivots, right, NULL, &info);
        for (int i = 0, a = 0; i < NODES; i++) {
            double left = gap[i];
            for (int b = 0; b < count && !closed[i]; b++)
                left += compliance[i * DIM * N + list[b] * DIM] * right[b];
            next[i] = closed[i] ? right[a++] > 0.0 : left < 0.0;
            changes |= next[i] != closed[i];
        }
        memcpy(closed, next, sizeof closed);
    }
    for (int a = 0; a < count; a++)
        to->force[list[a] * DIM] = fmax(right[a], 0.0);
}

/* The certificate of the answer in work, and the state that it leaves: OK, or ERROR with its reason. */
static int judges(unit *u) {
    scratch *w = u->work;
    const history *past = &u->past;
    const double *out = w->answer, *laws = w->reals;
    const Judged about = {NODES, DIM, TYPICAL, w->follower->law, own,
                          given.frames, given.reaction, BALANCED, rim};
    int at_rim = account_for(&about, out, out + N, out + 2 * N, past->yielded, past->slip,
                             past->travelled, past->sliding, w->reals, w->codes);
    if (!(laws[0] <= ACCEPT && laws[1] <= ACCEPT && laws[2] <= ACCEPT && laws[3] <= ACCEPT_BALANCE))
        return DISCARD;
    return at_rim ? says(u, "the contact reaches the end of the candidate zone") : OK;
}

/* Finds an answer at ``offset``: by following the last increment; from a guess; by guesses on the way
   from the motion before, in 2, 4, ... pieces, of which only the last one counts. */
static int solves(unit *u, const double *before, const double *offset, const double *change) {
    scratch *w = u->work;
    const history *past = &u->past;
    double length = 0.0, along = 0.0, whole = 0.0, lowest = INFINITY, here[N];
    for (int a = 0; a < 2; a++) {
        length += past->change[a] * past->change[a];
        along += past->change[a] * change[a], whole += change[a] * change[a];
    }
    double share = length > 0.0 ? along / length : 0.0;
    int onward = share > 0.0 && share * share * length >= ONWARD * whole, found;
    for (int i = 0; i < NODES; i++)
        lowest = fmin(lowest, offset[i * DIM]);
    if (lowest >= 0.0) { /* nothing is touched */
        memset(w->answer, 0, 2 * N * sizeof(double));
        memcpy(w->answer + 2 * N, offset, sizeof here);
        return judges(u);
    }
    if (follows(w, past, offset, !onward, fmin(share, LONGEST)) && (found = judges(u)) != DISCARD)
        return found;
    for (int pieces = 1; pieces <= MOST_PIECES; pieces *= 2) {
        history now = *past;
        int went = 1;
        for (int k = 1; k <= pieces && went; k++) {
            for (int j = 0; j < N; j++)
                here[j] = before[j] + (offset[j] - before[j]) * k / pieces;
            presses(w, k < pieces ? here : offset, &now);
            begins(&now, u->real[FRICTION]);
            if (now.largest > 0.0 || k == pieces)
                went = follows(w, &now, k < pieces ? here : offset, 0, 1.0);
            if (now.largest > 0.0)
                memcpy(now.force, w->answer, sizeof now.force);
        }
        if (went && (found = judges(u)) != DISCARD)
            return found;
        follower_base(w->follower, 0, NULL, NULL); /* an inverse that has drifted ends here */
    }
    return says(u, "no answer passes the certificate: use smaller moves");
}

static int unit_steps(unit *u, double step) {
    scratch *w = u->work;
    history *past = &u->past;
    double change[2] = {u->real[DY], u->real[DX]}, before[N], offset[N];
    const double *force = w->reals + 5, *state = force + 2 * N;
    if (!(isfinite(change[0]) && isfinite(change[1]) && step > 0.0))
        return says(u, "dx, dy must be finite, and the step over 0");
    for (int j = 0; j < N; j++) {
        before[j] = j % DIM ? -past->slip[j - j / DIM - 1] : given.clearance[j / DIM];
        for (int a = 0; a < 2; a++)
            before[j] += past->motion[a] * given.modes[a][j];
        offset[j] = before[j] + change[0] * given.modes[0][j] + change[1] * given.modes[1][j];
    }
    w->follower->law.coefficient = u->real[FRICTION];
    if (solves(u, before, offset, change) != OK)
        return ERROR;
    past->largest = w->reals[4];
    memcpy(past->force, w->answer, sizeof past->force);
    memcpy(past->yielded, w->answer + N, sizeof past->yielded);
    memcpy(past->ahead, force + N, sizeof past->ahead);
    memcpy(past->slip, state, sizeof past->slip);
    memcpy(past->travelled, state + N - NODES, sizeof past->travelled);
    memcpy(past->sliding, state + N, sizeof past->sliding);
    memcpy(past->status, w->codes + NODES, sizeof past->status);
    for (int a = 0; a < 2; a++) {
        past->motion[a] += change[a], past->change[a] = change[a];
        u->integer[a] = 0;
        u->real[NORMAL + a] = 0.0;
    }
    for (int i = 0; i < NODES; i++) {
        u->real[NORMAL] -= HALVES * force[i * DIM + 1], u->real[TANGENTIAL] += HALVES * force[i * DIM];
        u->integer[0] += w->codes[i] != OPEN, u->integer[1] += w->codes[i] == STICK;
    }
    for (int g = 0; g < GAGES; g++) {
        u->real[READING + g] = 0.0;
        for (int j = 0; j < N; j++)
            u->real[READING + g] += given.readout[g * N + j] * force[j];
    }
    u->real[APPROACH] = past->motion[0], u->real[SHEAR] = past->motion[1];
    u->boolean[0] = u->integer[1] > 0 && u->real[TANGENTIAL] > NEWTONS * u->real[MASS];
    return OK;
}
