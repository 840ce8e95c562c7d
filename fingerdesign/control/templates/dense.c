/* The ten routines of BLAS and LAPACK that kernel.c takes, for the few cases in which it does: unit
   strides, beta one or zero, the sides and halves named here. Columns are contiguous (Fortran's order). */

#include <math.h>
#include <stddef.h>

static void add_scaled(double by, const double *restrict x, double *restrict y, int n) {
    for (int i = 0; i < n; i++)
        y[i] += by * x[i];
}

static void dense_dgemv(const char *t, const int *m, const int *n, const double *by, const double *a,
                        const int *lda, const double *x, const int *one, const double *beta,
                        double *y, const int *also_one) {
    (void)t, (void)one, (void)beta, (void)also_one;
    for (int j = 0; j < *n; j++)
        add_scaled(*by * x[j], a + (size_t)j * *lda, y, *m);
}

static void dense_dsymv(const char *half, const int *n, const double *by, const double *a,
                        const int *lda, const double *x, const int *one, const double *beta,
                        double *y, const int *also_one) {
    dense_dgemv(half, n, n, by, a, lda, x, one, beta, y, also_one); /* both halves are there */
}

static void dense_dgemm(const char *ta, const char *tb, const int *m, const int *n, const int *k,
                        const double *by, const double *a, const int *lda, const double *b,
                        const int *ldb, const double *beta, double *c, const int *ldc) {
    for (int j = 0; j < *n; j++) {
        double *column = c + (size_t)j * *ldc;
        for (int i = 0; i < *m && *beta == 0.0; i++)
            column[i] = 0.0;
        for (int l = 0; l < *k && *ta == 'N'; l++)
            add_scaled(*by * (*tb == 'N' ? b[l + (size_t)j * *ldb] : b[j + (size_t)l * *ldb]),
                       a + (size_t)l * *lda, column, *m);
        for (int i = 0; i < *m && *ta == 'T'; i++) {
            double sum = 0.0;
            for (int l = 0; l < *k; l++)
                sum += a[l + (size_t)i * *lda] * b[l + (size_t)j * *ldb];
            column[i] += *by * sum;
        }
    }
}

/* B <- B A^T of a lower triangle A. */
static void dense_dtrmm(const char *s, const char *u, const char *t, const char *d, const int *m,
                        const int *n, const double *by, const double *a, const int *lda, double *b,
                        const int *ldb) {
    (void)s, (void)u, (void)t, (void)d, (void)by;
    for (int j = *n - 1; j >= 0; j--) {
        double *column = b + (size_t)j * *ldb;
        for (int i = 0; i < *m; i++)
            column[i] *= a[j + (size_t)j * *lda];
        for (int k = 0; k < j; k++)
            add_scaled(a[j + (size_t)k * *lda], b + (size_t)k * *ldb, column, *m);
    }
}

/* Cholesky's lower factor; info > 0 where there is none. */
static void dense_dpotrf(const char *u, const int *n, double *a, const int *lda, int *info) {
    (void)u, *info = 0;
    for (int j = 0; j < *n; j++) {
        double *column = a + (size_t)j * *lda;
        for (int k = 0; k < j; k++)
            add_scaled(-a[j + (size_t)k * *lda], a + (size_t)k * *lda + j, column + j, *n - j);
        if (!(column[j] > 0.0)) {
            *info = j + 1;
            return;
        }
        double root = sqrt(column[j]);
        for (int i = j; i < *n; i++)
            column[i] /= root;
    }
}

/* Inverse of a lower triangle, in place. */
static void dense_dtrtri(const char *u, const char *d, const int *n, double *a, const int *lda,
                         int *info) {
    (void)u, (void)d, *info = 0;
    for (int j = *n - 1; j >= 0; j--) {
        double *column = a + (size_t)j * *lda, own = 1.0 / column[j];
        for (int k = *n - 1; k > j; k--) { /* the inverse below, at hand, times the rest of the column */
            double by = -own * column[k];
            column[k] = 0.0;
            add_scaled(by, a + (size_t)k * *lda + k, column + k, *n - k);
        }
        column[j] = own;
    }
}

/* LU factors with row exchanges, and the solution of A^T x = b with them, in either precision. */
#define FACTORS(real, getrf, getrs, size_of)                                                       \
    static void getrf(const int *m, const int *n, real *a, const int *lda, int *pivot, int *info) { \
        (void)m, *info = 0;                                                                        \
        for (int j = 0; j < *n; j++) {                                                             \
            real *restrict column = a + (size_t)j * *lda;                                          \
            int top = j;                                                                           \
            for (int i = j + 1; i < *n; i++)                                                       \
                top = size_of(column[i]) > size_of(column[top]) ? i : top;                         \
            pivot[j] = top;                                                                        \
            if (!(size_of(column[top]) > 0)) {                                                     \
                *info = j + 1;                                                                     \
                return;                                                                            \
            }                                                                                      \
            for (int k = 0; k < *n && top != j; k++) {                                             \
                real held = a[j + (size_t)k * *lda];                                               \
                a[j + (size_t)k * *lda] = a[top + (size_t)k * *lda];                               \
                a[top + (size_t)k * *lda] = held;                                                  \
            }                                                                                      \
            for (int i = j + 1; i < *n; i++)                                                       \
                column[i] /= column[j];                                                            \
            for (int k = j + 1; k < *n; k++) {                                                     \
                real *restrict other = a + (size_t)k * *lda, by = other[j];                        \
                for (int i = j + 1; i < *n; i++)                                                   \
                    other[i] -= by * column[i];                                                    \
            }                                                                                      \
        }                                                                                          \
    }                                                                                              \
    static void getrs(const char *t, const int *n, const int *count, const real *a, const int *lda, \
                      const int *pivot, real *b, const int *ldb, int *info) {                      \
        (void)t, (void)count, (void)ldb, *info = 0;                                                \
        for (int j = 0; j < *n; j++) {                                                             \
            for (int i = 0; i < j; i++)                                                            \
                b[j] -= a[i + (size_t)j * *lda] * b[i];                                            \
            b[j] /= a[j + (size_t)j * *lda];                                                       \
        }                                                                                          \
        for (int j = *n - 1; j >= 0; j--)                                                          \
            for (int i = j + 1; i < *n; i++)                                                       \
                b[j] -= a[i + (size_t)j * *lda] * b[i];                                            \
        for (int j = *n - 1; j >= 0; j--) {                                                        \
            real held = b[j];                                                                      \
            b[j] = b[pivot[j]];                                                                    \
            b[pivot[j]] = held;                                                                    \
        }                                                                                          \
    }

FACTORS(double, dense_dgetrf, dense_dgetrs, fabs)
FACTORS(float, dense_sgetrf, dense_sgetrs, fabsf)
