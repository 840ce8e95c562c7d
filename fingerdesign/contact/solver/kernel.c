/* Increments followed from the one before, and what an accepted one leaves: compiled.

   The same equations as tracking.py and linearised.py solve, which stay its judge: from forces f*,
   their motion C f* and the statuses known, with the inverse G on a base of nodes,

       f = f* - G (C f* + w - rest) + G u,        v = rest + u,

   Newton finds u: zero at sticking nodes, slips at sliding ones, free at open ones. Here every node
   of the base is a candidate, as only columns of G whose u moves are read; and what numpy pays for
   each small array is not paid. Matrices are symmetric, (rows, columns) contiguous along columns.
   BLAS and LAPACK are those of SciPy, handed in by kernel.py. C99. */

#include <math.h>
#include <stdint.h>
#include <stdlib.h>
#include <string.h>

enum { OPEN, STICK, SLIP };          /* as in laws.py */
enum { NONE, FOUND, NEEDS_A_BASE };  /* what following came to */

/* Bounds with tracking.py's and linearised.py's names and reasons. */
static const double TOLERANCE = 1e-10, OPPOSED = 1e-8, RING = 0.03, MORE = 1.5, WIDEST = 4.0;
static const double CLOSE = 0.1, ON_LIMIT = 1e-9;
static const int MOST = 15, ROUNDS = 6, LEAST = 8;
static const double FEW = 2.0;       /* steps with old factors that cost what new ones do */
static const int SPARE = 4, CHEAP = 1; /* open nodes left, new factors: widen the base beforehand */
static const int GAP = 2;            /* zeros between columns that are read as one run */

typedef void Symv(const char *, const int *, const double *, const double *, const int *,
                  const double *, const int *, const double *, double *, const int *);
typedef void Gemv(const char *, const int *, const int *, const double *, const double *,
                  const int *, const double *, const int *, const double *, double *, const int *);
typedef void Gemm(const char *, const char *, const int *, const int *, const int *,
                  const double *, const double *, const int *, const double *, const int *,
                  const double *, double *, const int *);
typedef void Trmm(const char *, const char *, const char *, const char *, const int *, const int *,
                  const double *, const double *, const int *, double *, const int *);
typedef void Potrf(const char *, const int *, double *, const int *, int *);
typedef void Trtri(const char *, const char *, const int *, double *, const int *, int *);
typedef void DFactor(const int *, const int *, double *, const int *, int *, int *);
typedef void SFactor(const int *, const int *, float *, const int *, int *, int *);
typedef void DSolve(const char *, const int *, const int *, const double *, const int *,
                    const int *, double *, const int *, int *);
typedef void SSolve(const char *, const int *, const int *, const float *, const int *,
                    const int *, float *, const int *, int *);

static struct {
    Symv *dsymv;
    Gemv *dgemv;
    Gemm *dgemm;
    Trmm *dtrmm;
    Potrf *dpotrf;
    Trtri *dtrtri;
    DFactor *dgetrf;
    SFactor *sgetrf;
    DSolve *dgetrs;
    SSolve *sgetrs;
} blas;

void bind_blas(void *const *given)
{
    memcpy(&blas, given, sizeof blas);
}

/* y (n,) += sign A x of a symmetric A (n, n): by halves, or by the rows where x is not zero. */
static void add_product(double sign, const double *matrix, int n, const double *x, double *y)
{
    static const int one = 1;
    static const double unit = 1.0;
    int count = 0;
    for (int j = 0; j < n; j++)
        count += x[j] != 0.0;
    if (2 * count > n) {
        blas.dsymv("U", &n, &sign, matrix, &n, x, &one, &unit, y, &one);
        return;
    }
    for (int j = 0; j < n; j++) {
        if (x[j] == 0.0)
            continue;
        int last = j;
        for (int i = j + 1; i < n && i - last <= GAP + 1; i++)
            if (x[i] != 0.0)
                last = i;
        int width = last - j + 1;
        blas.dgemv("N", &n, &width, &sign, matrix + (size_t)j * n, &n, x + j, &one, &unit, y, &one);
        j = last;
    }
}

static double length_of(const double *vector, int size)
{
    return size == 1 ? fabs(vector[0]) : sqrt(vector[0] * vector[0] + vector[1] * vector[1]);
}

/* Friction as in shapes/friction.py, laid out as in kernel.py: bounds of forces, areas (m,) mm^2; a
   law without areas is Coulomb's. shares (m,) of the bound, NULL: 1 of all. */
typedef struct {
    double coefficient, strength, cap, exponent, reference, steepest;
    const double *areas, *shares;
} Law;

static double share_of(const Law *law, int64_t node)
{
    return law->shares ? law->shares[node] : 1.0;
}

/* mu p0^n p^(1 - n) of a node, as a force. */
static double rising(const Law *law, double area, double pressed)
{
    if (law->exponent == 0.0)
        return law->coefficient * pressed;
    double scale = law->coefficient * pow(law->reference * area, law->exponent);
    return scale * pow(pressed, 1.0 - law->exponent);
}

static double bound_of(const Law *law, int64_t node, double normal)
{
    double share = share_of(law, node);
    if (!law->areas)
        return law->coefficient * share * normal;
    double area = law->areas[node];
    double free = law->strength * area + rising(law, area, fmax(normal, 0.0));
    return share * fmin(fmin(law->steepest * normal, free), law->cap * area);
}

static double slope_of(const Law *law, int64_t node, double normal)
{
    double share = share_of(law, node);
    if (!law->areas)
        return law->coefficient * share;
    double area = law->areas[node], pressed = fmax(normal, 0.0), top = law->cap * area;
    double rise = rising(law, area, pressed), free = law->strength * area + rise;
    if (law->steepest * normal <= free && law->steepest * normal <= top)
        return share * law->steepest;
    return free < top ? share * (1.0 - law->exponent) * rise / pressed : 0.0;
}

/* One path's increments on one compliance. Of m nodes: compliance, rho. Of the base's
   k nodes, size = k dim: the rest. */
typedef struct {
    int m, dim, n;
    double length;
    Law law;
    const double *compliance, *rho;

    int k, size;
    const int64_t *nodes;
    const double *inverse;
    double stiffness;
    double *own_rho;
    unsigned char *inside, *needed;

    /* Newton: forces, motions at u = 0, u, and where it stands. */
    double *force, *rest, *u, *rows, *direction, *trial, *step, *moved;
    int *sliding, slides;
    unsigned char *status, *kept;

    /* Factors of the derivative in the unknowns ``free``, at the statuses ``held``. */
    int factored, frees, factored_slides;
    int *free, *factored_sliding, *pivots;
    unsigned char *held;
    double *weights, *turn, *right;
    void *factors;

    /* The increment being solved, of all nodes. */
    const double *offset, *known_force, *known_yielded;
    double *force_out, *yielded_out, *motion_out;
    double *here, *resting, *ahead, *gap;
    unsigned char *now;
    double largest, residual;
    int round, begun, iterations, renewed;

    double *work; /* (n, n) */
    void *memory[4];
} Follower;

void follower_free(Follower *f)
{
    if (f)
        for (int i = 0; i < 4; i++)
            free(f->memory[i]);
    free(f);
}

/* NULL where memory is short. ``compliance``, ``rho``, the law's areas and shares must outlive it. */
Follower *follower_new(int m, int dim, const Law *law, double length, const double *compliance,
                       const double *rho)
{
    Follower *f = calloc(1, sizeof *f);
    if (!f)
        return NULL;
    size_t n = (size_t)m * dim;
    double *reals = f->memory[0] = calloc(20 * n, sizeof(double));
    int *wholes = f->memory[1] = calloc(4 * n, sizeof(int) + 2);
    f->factors = f->memory[2] = malloc(n * n * sizeof(double)); /* of which few pages are touched */
    f->work = f->memory[3] = malloc(n * n * sizeof(double));
    if (!reals || !wholes || !f->factors || !f->work) {
        follower_free(f);
        return NULL;
    }
    f->m = m, f->dim = dim, f->n = (int)n;
    f->law = *law, f->length = length;
    f->compliance = compliance, f->rho = rho;
    double **each[] = {&f->own_rho, &f->force, &f->rest,  &f->u,       &f->rows, &f->direction,
                       &f->trial,   &f->step,  &f->moved, &f->turn,    &f->right, &f->here,
                       &f->resting, &f->ahead, &f->gap};
    for (size_t i = 0; i < sizeof each / sizeof *each; i++, reals += n)
        *each[i] = reals;
    f->weights = reals; /* up to six a node */
    f->sliding = wholes, f->free = wholes + n, f->factored_sliding = wholes + 2 * n;
    f->pivots = wholes + 3 * n;
    unsigned char *bytes = (unsigned char *)(wholes + 4 * n);
    f->inside = bytes, f->needed = bytes + n, f->status = bytes + 2 * n, f->kept = bytes + 3 * n;
    f->held = bytes + 4 * n, f->now = bytes + 5 * n;
    return f;
}

/* Another friction from here on; its areas and shares must outlive their use. */
void follower_meet(Follower *f, const Law *law)
{
    f->law = *law, f->factored = 0;
}

/* The inverse (k dim, k dim) on ``nodes`` (k,): both must outlive their use; k = 0 for none. */
void follower_base(Follower *f, int k, const int64_t *nodes, const double *inverse)
{
    memset(f->inside, 0, f->m);
    f->k = k, f->size = k * f->dim, f->nodes = nodes, f->inverse = inverse;
    f->factored = 0, f->stiffness = 0.0;
    for (int i = 0; i < k; i++) {
        f->inside[nodes[i]] = 1;
        f->own_rho[i] = f->rho[nodes[i]];
        f->stiffness += f->own_rho[i] / k;
    }
}

/* out (n, n) = old (k, k), bordered by zeros, + side^T side of side (rank, n). By panels that stay in
   the cache, the lower half mirrored: were it not symmetric to the last digit, each bordering would
   multiply its error by ten. */
static void corrected(const double *old, int k, const double *side, int rank, double *out, int n)
{
    enum { PANEL = 64 };
    static const double unit = 1.0;
    for (int low = 0; low < n; low += PANEL) {
        int rows = n - low < PANEL ? n - low : PANEL, high = low + rows;
        for (int i = low; i < high; i++) {
            double *row = out + (size_t)i * n;
            int known = i >= k ? 0 : k < high ? k : high;
            if (known)
                memcpy(row, old + (size_t)i * k, known * sizeof(double));
            memset(row + known, 0, (high - known) * sizeof(double));
        }
        blas.dgemm("N", "T", &high, &rows, &rank, &unit, side, &n, side + low, &n, &unit,
                   out + (size_t)low * n, &n);
        for (int j = 0; j < high; j++)
            for (int i = j < low ? low : j + 1; i < high; i++)
                out[(size_t)j * n + i] = out[(size_t)i * n + j];
    }
}

/* The base's inverse bordered by nodes that join (count,), into ``out``; zero where that is singular,
   or where they are too many for the memory at hand.

   With R^T R = (C_jj - C_jb G C_bj)^-1 and side = R (C_jb G, -1): G by zeros + side^T side. */
int follower_border(Follower *f, const int64_t *joins, int count, double *out)
{
    static const double one = 1.0, zero = 0.0, less = -1.0;
    int dim = f->dim, old = f->size, rank = count * dim, n = old + rank, info = 0;
    if ((size_t)rank * (2 * n + rank) > (size_t)f->n * f->n)
        return 0;
    double *rows = f->work, *side = rows + (size_t)rank * n, *root = side + (size_t)rank * n;
    for (int a = 0; a < rank; a++) {
        const double *from = f->compliance + (size_t)(joins[a / dim] * dim + a % dim) * f->n;
        for (int j = 0; j < old; j++)
            rows[(size_t)a * old + j] = from[f->nodes[j / dim] * dim + j % dim];
        for (int b = 0; b < rank; b++)
            root[a * rank + b] = from[joins[b / dim] * dim + b % dim];
    }
    blas.dgemm("N", "N", &old, &rank, &old, &one, f->inverse, &old, rows, &old, &zero, side, &n);
    blas.dgemm("T", "N", &rank, &rank, &old, &less, rows, &old, side, &n, &one, root, &rank);
    for (int a = 0; a < rank; a++)
        for (int b = 0; b < a; b++)
            root[b * rank + a] = 0.5 * (root[b * rank + a] + root[a * rank + b]);
    blas.dpotrf("L", &rank, root, &rank, &info);
    if (!info)
        blas.dtrtri("L", "N", &rank, root, &rank, &info);
    if (info)
        return 0;
    blas.dtrmm("R", "L", "T", "N", &old, &rank, &one, root, &rank, side, &n);
    for (int a = 0; a < rank; a++)
        for (int b = 0; b < rank; b++)
            side[(size_t)a * n + old + b] = b > a ? 0.0 : -root[b * rank + a];
    corrected(f->inverse, old, side, rank, out, n);
    return 1;
}

/* The laws' rows at the forces and motions of now, by the statuses given or those that follow.
   Returns the largest, not a number where any is. */
static double evaluate(Follower *f, const unsigned char *given)
{
    int dim = f->dim;
    double worst = 0.0, sum = 0.0;
    f->slides = 0;
    for (int i = 0; i < f->k; i++) {
        const double *force = f->force + i * dim;
        double *rows = f->rows + i * dim, motion[3], tried[3];
        for (int a = 0; a < dim; a++) {
            motion[a] = f->rest[i * dim + a] + f->u[i * dim + a];
            tried[a] = force[a] - f->own_rho[i] * motion[a];
        }
        double size = length_of(tried + 1, dim - 1);
        int status = tried[0] > 0.0 ? (size > bound_of(&f->law, f->nodes[i], tried[0]) ? SLIP : STICK) : OPEN;
        if (given)
            status = given[i];
        f->status[i] = (unsigned char)status;
        for (int a = 0; a < dim; a++)
            rows[a] = status == OPEN ? force[a] : f->stiffness * motion[a];
        if (status == SLIP) {
            double *e = f->direction + 2 * f->slides;
            size = fmax(size, 1e-300);
            f->trial[f->slides] = size;
            f->sliding[f->slides++] = i;
            e[0] = tried[1] / size;
            rows[1] = e[0] * force[1] - bound_of(&f->law, f->nodes[i], force[0]);
            if (dim == 3) {
                e[1] = tried[2] / size;
                rows[1] += e[1] * force[2];
                rows[2] = e[0] * force[2] - e[1] * force[1];
            }
        }
        for (int a = 0; a < dim; a++) {
            worst = fmax(worst, fabs(rows[a]));
            sum += rows[a];
        }
    }
    return isfinite(sum) ? worst : NAN;
}

/* Weights of the laws of the s-th sliding node: (dim - 1, dim) of dF, and of dv in its last row. */
static void weigh(Follower *f, int s)
{
    int i = f->sliding[s];
    const double *force = f->force + f->dim * i, *e = f->direction + 2 * s;
    double *weights = f->weights + 6 * s, *turn = f->turn + 2 * s;
    memset(weights, 0, 6 * sizeof *weights);
    weights[0] = -slope_of(&f->law, f->nodes[i], force[0]), weights[1] = e[0];
    if (f->dim == 2)
        return;
    weights[2] = e[1];
    double bound = bound_of(&f->law, f->nodes[i], fmax(force[0], 0.0));
    double along = e[0] * force[1] + e[1] * force[2];
    /* Near the answer 1 - q is small, and right only with the force itself. */
    if (!(fabs(along - bound) < CLOSE * bound))
        along = bound;
    double q = fmin(fmax(along / f->trial[s], 0.0), 1.0);
    weights[4] = (q - 1.0) * e[1], weights[5] = (1.0 - q) * e[0];
    turn[0] = -f->own_rho[i] * q * e[1], turn[1] = f->own_rho[i] * q * e[0];
}

/* Columns ``free`` of a row, weighed with up to two more, to single or double precision. */
static void put_row(const Follower *f, int row, const double *weights, const double *first)
{
    int n = f->frees, size = f->size;
    const double *second = first + size, *third = second + (f->dim == 3 ? size : 0);
    double w0 = weights[0], w1 = weights[1], w2 = f->dim == 3 ? weights[2] : 0.0;
    if (f->dim == 2) {
        double *into = (double *)f->factors + (size_t)row * n;
        for (int j = 0; j < n; j++)
            into[j] = w0 * first[f->free[j]] + w1 * second[f->free[j]];
        return;
    }
    float *into = (float *)f->factors + (size_t)row * n;
    for (int j = 0; j < n; j++) {
        int column = f->free[j];
        into[j] = (float)(w0 * first[column] + w1 * second[column] + w2 * third[column]);
    }
}

static void put_open_row(const Follower *f, int row)
{
    const double *from = f->inverse + (size_t)f->free[row] * f->size;
    size_t start = (size_t)row * f->frees;
    for (int j = 0; j < f->frees; j++) {
        if (f->dim == 2)
            ((double *)f->factors)[start + j] = from[f->free[j]];
        else
            ((float *)f->factors)[start + j] = (float)from[f->free[j]];
    }
}

/* LU factors of the derivative where Newton stands; zero where it is singular. Steps are corrected
   by the next one: single precision is as good, and twice as fast. In the plane all is linear, and
   one step should do. */
static int factorise(Follower *f)
{
    int dim = f->dim, info = 0, count = 0;
    for (int s = 0; s < f->slides; s++) {
        f->factored_sliding[s] = f->sliding[s];
        for (int a = 1; a < dim; a++)
            f->free[count++] = f->sliding[s] * dim + a;
    }
    for (int i = 0; i < f->k; i++)
        for (int a = 0; a < dim && f->status[i] == OPEN; a++)
            f->free[count++] = i * dim + a;
    memcpy(f->held, f->status, f->k);
    int slips = f->slides * (dim - 1);
    f->frees = count, f->factored_slides = f->slides, f->factored = 0;
    for (int s = 0; s < f->slides; s++) {
        const double *first = f->inverse + (size_t)f->sliding[s] * dim * f->size;
        weigh(f, s);
        for (int a = 0; a < dim - 1; a++)
            put_row(f, s * (dim - 1) + a, f->weights + 6 * s + 3 * a, first);
        if (dim == 3) {
            float *across = (float *)f->factors + (size_t)(2 * s + 1) * count + 2 * s;
            across[0] += (float)f->turn[2 * s], across[1] += (float)f->turn[2 * s + 1];
        }
    }
    for (int row = slips; row < count; row++)
        put_open_row(f, row);
    if (count && dim == 3)
        blas.sgetrf(&count, &count, f->factors, &count, f->pivots, &info);
    else if (count)
        blas.dgetrf(&count, &count, f->factors, &count, f->pivots, &info);
    f->factored = info == 0;
    f->renewed++;
    return f->factored;
}

/* The right side, in the factors' precision, replaced by what solves for it. */
static void substitute(Follower *f)
{
    static const int one = 1;
    int n = f->frees, info;
    if (f->dim == 2) {
        blas.dgetrs("T", &n, &one, f->factors, &n, f->pivots, f->right, &n, &info);
        return;
    }
    float *coarse = (float *)f->moved;
    for (int j = 0; j < n; j++)
        coarse[j] = (float)f->right[j];
    blas.sgetrs("T", &n, &one, f->factors, &n, f->pivots, coarse, &n, &info);
    for (int j = 0; j < n; j++)
        f->right[j] = coarse[j];
}

/* One Newton step with the factors at hand: u and the forces move. */
static void move_on(Follower *f)
{
    int dim = f->dim, size = f->size, slips = f->factored_slides * (dim - 1), any = 0;
    double *step = f->step;
    for (int i = 0; i < f->k; i++)
        for (int a = 0; a < dim; a++) {
            int j = i * dim + a;
            int fixed = f->held[i] == STICK || (f->held[i] == SLIP && a == 0);
            step[j] = 0.0;
            if (fixed) {
                step[j] = -f->rest[j] - f->u[j];
                f->u[j] = -f->rest[j];
                any |= step[j] != 0.0;
            }
        }
    memset(f->moved, 0, size * sizeof(double));
    if (any)
        add_product(1.0, f->inverse, size, step, f->moved);
    for (int s = 0; s < f->factored_slides; s++) {
        int at = f->factored_sliding[s] * dim;
        for (int a = 0; a < dim - 1; a++) {
            const double *weights = f->weights + 6 * s + 3 * a;
            double sum = f->rows[at + 1 + a];
            for (int b = 0; b < dim; b++)
                sum += weights[b] * f->moved[at + b];
            f->right[s * (dim - 1) + a] = sum;
        }
    }
    for (int j = slips; j < f->frees; j++)
        f->right[j] = f->rows[f->free[j]] + f->moved[f->free[j]];
    for (int j = 0; j < size; j++)
        f->force[j] += f->moved[j];
    if (!f->frees)
        return;
    substitute(f);
    memset(step, 0, size * sizeof(double));
    for (int j = 0; j < f->frees; j++) {
        step[f->free[j]] = -f->right[j];
        f->u[f->free[j]] -= f->right[j];
    }
    add_product(1.0, f->inverse, size, step, f->force);
}

/* Whether friction is against each slip, or the slip as good as none. */
static int opposed(const Follower *f, double scale)
{
    for (int s = 0; s < f->slides && f->dim == 3; s++) {
        int i = 3 * f->sliding[s];
        const double *force = f->force + i;
        double slip[2] = {f->rest[i + 1] + f->u[i + 1], f->rest[i + 2] + f->u[i + 2]}, off[2];
        double length = length_of(slip, 2);
        double bound = bound_of(&f->law, f->nodes[f->sliding[s]], force[0]);
        for (int a = 0; a < 2; a++)
            off[a] = force[1 + a] + bound * slip[a] / fmax(length, 1e-300);
        if (!(fmin(length_of(off, 2), length / f->length) <= OPPOSED * scale))
            return 0;
    }
    return 1;
}

/* Whether as many steps as new factors cost would not do, at the rate of the last one. */
static int worn(const Follower *f, double residual, double last)
{
    double few = FEW + (f->frees / 200.0) * (f->frees / 200.0);
    return residual * pow(residual / last, few) > TOLERANCE;
}

/* Newton from u; zero where it does not settle. given: statuses that the first iteration keeps. */
static int newton(Follower *f, const unsigned char *given)
{
    double last = 1e30, scale = f->largest;
    for (int iteration = 0; iteration < MOST; iteration++) {
        double residual = evaluate(f, given) / scale;
        if (residual <= TOLERANCE && iteration && opposed(f, scale)) {
            f->residual = residual;
            f->iterations += iteration;
            return 1;
        }
        if (!isfinite(residual))
            return 0;
        if (!f->factored || worn(f, residual, last) || memcmp(f->held, f->status, f->k))
            if (!factorise(f))
                return 0;
        move_on(f);
        given = NULL;
        last = fmax(residual, 1e-30);
    }
    return 0;
}

/* Whether the base holds all nodes needed, and not too many others. */
static int base_serves(const Follower *f, int needed)
{
    int ring = (int)(RING * needed), others = f->k - needed;
    if (!f->k || others > WIDEST * (ring > LEAST ? ring : LEAST))
        return 0;
    for (int i = 0; i < f->m; i++)
        if (f->needed[i] && !f->inside[i])
            return 0;
    return 1;
}

/* Forces of the base's nodes, their motion with all others, and what else they touch. */
static int conclude(Follower *f)
{
    int dim = f->dim, touches = 0;
    double deepest = -TOLERANCE * f->length * f->largest;
    memset(f->force_out, 0, f->n * sizeof(double));
    for (int i = 0; i < f->k; i++) {
        int64_t node = f->nodes[i];
        f->now[node] = f->status[i];
        memcpy(f->ahead + node * dim, f->u + i * dim, dim * sizeof(double));
        if (f->status[i] != OPEN)
            memcpy(f->force_out + node * dim, f->force + i * dim, dim * sizeof(double));
    }
    memset(f->yielded_out, 0, f->n * sizeof(double));
    add_product(1.0, f->compliance, f->n, f->force_out, f->yielded_out);
    for (int j = 0; j < f->n; j++)
        f->motion_out[j] = f->yielded_out[j] + f->offset[j];
    for (int i = 0; i < f->m; i++)
        touches += f->motion_out[i * dim] < deepest && !f->inside[i];
    if (!touches)
        return 1;
    for (int i = 0; i < f->m; i++) {
        f->gap[i] = f->motion_out[i * dim];
        for (int a = 0; a < dim && f->now[i] == OPEN; a++)
            f->ahead[i * dim + a] = f->yielded_out[i * dim + a] - f->known_yielded[i * dim + a];
        if (f->gap[i] < deepest && !f->inside[i])
            f->now[i] = STICK;
    }
    return 0;
}

/* Go on, the base having been brought where it was asked for: NONE, FOUND or NEEDS_A_BASE, and then
   the nodes needed (m,), and all nodes' gaps (m,), are read from follower_needed and _gap. */
int follower_go(Follower *f, int brought)
{
    int dim = f->dim;
    for (; f->round < ROUNDS; f->round++, brought = 0) {
        int needed = 0, closed = 0;
        for (int i = 0; i < f->m; i++) {
            f->needed[i] = f->now[i] != OPEN || f->gap[i] < 0.0;
            needed += f->needed[i];
            closed += f->now[i] != OPEN;
        }
        if (needed > MORE * closed + LEAST)
            return NONE;
        if (!brought && !base_serves(f, needed))
            return NEEDS_A_BASE;
        for (int i = 0; i < f->k; i++)
            for (int a = 0; a < dim; a++) {
                int j = i * dim + a;
                int64_t from = f->nodes[i] * dim + a;
                f->force[j] = f->known_force[from];
                f->rest[j] = f->resting[from];
                f->u[j] = f->ahead[from];
                f->step[j] = f->here[from] - f->rest[j] - f->u[j];
            }
        for (int i = 0; i < f->k; i++)
            f->kept[i] = f->now[f->nodes[i]];
        add_product(-1.0, f->inverse, f->size, f->step, f->force);
        if (!newton(f, f->begun ? NULL : f->kept))
            return NONE;
        f->begun = 1;
        if (conclude(f))
            return FOUND;
    }
    return NONE;
}

/* Begin an increment at ``offset``, from what is known of another (tracking.py's Known), and go on.

   turned: what slid mostly sticks. trial: of the known step, whose slips alone are u to begin with;
   else ``share`` of all that moved. The answer goes into force, yielded and motion (m, dim). */
int follower_begin(Follower *f, const double *offset, const double *known_force,
                   const double *known_yielded, const int64_t *status, const double *ahead,
                   double largest, int turned, int trial, double share, double *force,
                   double *yielded, double *motion)
{
    int dim = f->dim;
    f->offset = offset, f->known_force = known_force, f->known_yielded = known_yielded;
    f->force_out = force, f->yielded_out = yielded, f->motion_out = motion;
    f->largest = largest, f->round = f->begun = f->iterations = f->renewed = 0;
    for (int i = 0; i < f->m; i++) {
        double of = turned || (trial && status[i] != SLIP) ? 0.0 : share;
        f->now[i] = (unsigned char)(turned && status[i] == SLIP ? STICK : status[i]);
        for (int a = 0; a < dim; a++) {
            int j = i * dim + a;
            f->here[j] = known_yielded[j] + offset[j];
            f->resting[j] = f->now[i] == OPEN ? f->here[j] : 0.0;
            f->ahead[j] = of == 0.0 ? 0.0 : of * ahead[j];
        }
        f->gap[i] = f->here[i * dim] + f->ahead[i * dim];
    }
    return follower_go(f, 0);
}

const unsigned char *follower_needed(const Follower *f) { return f->needed; }
const double *follower_gap(const Follower *f) { return f->gap; }
double follower_residual(const Follower *f) { return f->residual; }
int follower_iterations(const Follower *f) { return f->iterations; }

/* Whether the base should be widened before the next increment: few open nodes are left in it, and
   this increment cost little. ``needed`` and ``gap`` are then of what was found. */
int follower_runs_short(Follower *f)
{
    int left = 0;
    for (int i = 0; i < f->k; i++)
        left += f->status[i] == OPEN;
    if (left > SPARE || f->renewed > CHEAP)
        return 0;
    for (int i = 0; i < f->m; i++) {
        f->needed[i] = f->now[i] != OPEN;
        f->gap[i] = f->motion_out[i * f->dim];
    }
    return 1;
}

/* What a certificate and a state are made of, of m nodes and one object: as in laws.py, problem.py. */
typedef struct {
    int m, dim;
    double typical;                    /* mm/N: a node's normal compliance, the median */
    Law law;
    const double *self_compliance;     /* (m,) */
    const double *frames;              /* (m, dim, dim): rows n, t1(, t2) */
    const double *readout;             /* (dim, m dim): the base's reaction to contact forces */
    const unsigned char *balanced;     /* (dim,): directions in which it must balance them */
    const unsigned char *rim;          /* (m,) */
} Judged;

/* An answer, the state that it starts from, and C f there; then what is made of them. */
typedef struct {
    const double *multiplier, *yielded, *motion, *before, *slip, *travelled, *sliding;
    double *certificate; /* complementarity, Coulomb, dissipation, balance, largest normal force */
    double *force, *ahead, *slip_after, *travelled_after, *sliding_after;
    int64_t *status, *touching;
} Account;

static double balance_of(const Judged *p, const Account *a, double pressed)
{
    int dim = p->dim;
    double worst = 0.0, sums[3] = {0.0, 0.0, 0.0};
    for (int i = 0; i < p->m; i++)
        for (int b = 0; b < dim; b++)
            sums[b] += a->force[i * dim + b];
    for (int b = 0; b < dim; b++) {
        const double *row = p->readout + (size_t)b * p->m * dim;
        for (int j = 0; j < p->m * dim; j++)
            sums[b] += row[j] * a->force[j];
        if (p->balanced[b])
            worst = fmax(worst, fabs(sums[b]));
    }
    return worst / fmax(pressed, 1e-300);
}

/* laws.certify of the answer, its forces in x, y(, z) in ``force``. */
static void certify(const Judged *p, const Account *a)
{
    int m = p->m, dim = p->dim;
    double *found = a->certificate, lowest = 0.0, widest = 0.0, least = 0.0, most = 0.0, sum = 0.0;
    double pressed = 0.0;
    int any = 0;
    for (int j = 0; j < m * dim; j++) {
        sum += a->multiplier[j] + a->motion[j];
        any |= a->multiplier[j] != 0.0;
    }
    if (!isfinite(sum)) {
        for (int i = 0; i < 5; i++)
            found[i] = INFINITY;
        return;
    }
    for (int i = 0; i < m; i++) {
        double normal = a->multiplier[i * dim], gap = a->motion[i * dim];
        pressed += normal;
        least = fmin(least, normal), most = fmax(most, normal);
        lowest = fmin(lowest, gap), widest = fmax(widest, fabs(gap));
        for (int b = 0; b < dim; b++) {
            double total = 0.0;
            for (int c = 0; c < dim; c++)
                total += p->frames[(i * dim + c) * dim + b] * a->multiplier[i * dim + c];
            a->force[i * dim + b] = total;
        }
    }
    found[0] = found[1] = found[2] = found[3] = 0.0, found[4] = most;
    if (!any) { /* nothing is touched: only penetration can be wrong */
        found[0] = -lowest / fmax(widest, 1e-300);
        return;
    }
    double scale = fmax(most, -least), length = scale * p->typical, outside = 0.0, product = 0.0;
    double loss = 0.0;
    for (int i = 0; i < m; i++) {
        const double *force = a->multiplier + i * dim, *motion = a->motion + i * dim;
        product = fmax(product, fabs(fmin(force[0] / scale, motion[0] / length)));
        double bound = bound_of(&p->law, i, fmax(force[0], 0.0)), moved = length_of(motion + 1, dim - 1);
        outside = fmax(outside, length_of(force + 1, dim - 1) - bound);
        double power = bound * moved; /* maximum dissipation: bound |d| + lambda_t . d = 0 */
        for (int b = 1; b < dim; b++)
            power += force[b] * motion[b];
        loss = fmax(loss, fabs(power) / fmax(moved, length));
    }
    found[0] = fmax(fmax(-least / scale, -lowest / length), product);
    found[1] = outside / scale, found[2] = loss / scale;
    found[3] = balance_of(p, a, pressed);
}

/* The state that an answer leaves if it is accepted. Returns whether a node of the rim carries a
   force. */
static int leave(const Judged *p, const Account *a)
{
    int dim = p->dim, at_rim = 0;
    for (int i = 0; i < p->m; i++) {
        const double *force = a->multiplier + i * dim, *motion = a->motion + i * dim;
        double own = p->self_compliance[i], tried[3], limit = bound_of(&p->law, i, force[0]);
        for (int b = 0; b < dim; b++)
            tried[b] = force[b] - motion[b] / own;
        double over = p->law.areas ? (1.0 + ON_LIMIT) * bound_of(&p->law, i, tried[0])
                                   : p->law.coefficient * share_of(&p->law, i) * (1.0 + ON_LIMIT) * tried[0];
        int slides = length_of(tried + 1, dim - 1) > over;
        int status = tried[0] > 0.0 ? STICK + slides : OPEN;
        double moved = length_of(motion + 1, dim - 1);
        int limited = length_of(force + 1, dim - 1) >= limit - ON_LIMIT * a->certificate[4];
        double slid = moved <= ON_LIMIT * own * force[0] ? a->sliding[i] : moved;
        slid = force[0] > 0.0 && limited ? slid : 0.0;
        if (slid > 0.0 && status == STICK)
            status = SLIP;
        a->status[i] = status;
        a->sliding_after[i] = slid;
        /* A sticking node has not moved, whatever the rounding; an open one starts anew. */
        a->travelled_after[i] = status == OPEN ? 0.0 : a->travelled[i] + (status == SLIP ? moved : 0.0);
        int touching = force[0] > 0.0 ? (status == SLIP ? SLIP : STICK) : OPEN;
        a->touching[i] = touching;
        for (int b = 0; b < dim; b++) {
            int j = i * dim + b;
            double ahead = touching == OPEN ? a->yielded[j] - a->before[j] : 0.0;
            a->ahead[j] = touching == SLIP && b ? motion[b] : ahead;
        }
        for (int b = 1; b < dim; b++) {
            int j = i * (dim - 1) + b - 1;
            a->slip_after[j] = motion[b] + a->slip[j];
        }
        at_rim |= p->rim[i] && force[0] > 0.0;
    }
    return at_rim;
}

/* The outcome (outcome.py) of an answer: reals hold the certificate and the largest force (5,), force
   and ahead (m, dim), slip (m, dim - 1), travelled and sliding (m,); codes status and touching. */
int account_for(const Judged *p, const double *multiplier, const double *yielded,
                const double *motion, const double *before, const double *slip,
                const double *travelled, const double *sliding, double *reals, int64_t *codes)
{
    int m = p->m, n = m * p->dim;
    double *force = reals + 5, *slip_after = force + 2 * n;
    Account account = {
        multiplier, yielded,   motion,         before,         slip,
        travelled,  sliding,   reals,          force,          force + n,
        slip_after, slip_after + n - m, slip_after + n, codes, codes + m,
    };
    certify(p, &account);
    return leave(p, &account);
}
