/* The workloads of benchmarks/speed.py in C, as one would write them for speed: what Python is measured against.
 *
 * Compiled on the spot with gcc -O3 -march=native. Positions are finite and the interval is constant; nothing is
 * checked. Filters of many gain sets or many runs go side by side in LANES, innermost, so that the compiler
 * vectorises; the order of a filter is a constant in every loop.
 */

#include <math.h>
#include <stdlib.h>
#include <string.h>

#define LANES 64
#define INLINE static inline __attribute__((always_inline))

/* ---------------------------------------------------------------- one track, all states */

typedef struct {
    double *predicted, *smoothed, *innovation;
} Track;

/* One axis: start by two points, outputs (n, order), innovation with a stride. */
INLINE void track(const int order, long n, long stride, const double *z, double t, const double *g,
                  double *predicted, double *smoothed, double *innovation)
{
    const double half = t * t / 2, sixth = t * t * t / 6;
    const double k0 = g[0], k1 = g[1] / t, k2 = order > 2 ? g[2] / (t * t) : 0, k3 = order > 3 ? g[3] / (t * t * t) : 0;
    double x = z[stride], v = (z[stride] - z[0]) / t, a = 0, j = 0;
    for (long i = 0; i < 2; i++)
        for (int r = 0; r < order; r++) {
            predicted[i * order + r] = NAN;
            smoothed[i * order + r] = i ? (r == 0 ? x : r == 1 ? v : 0) : (r ? NAN : z[0]);
        }
    innovation[0] = innovation[stride] = NAN;
    for (long i = 2; i < n; i++) {
        double *p = predicted + i * order, *s = smoothed + i * order;
        x += t * v;
        if (order > 2) { x += half * a; v += t * a; }
        if (order > 3) { x += sixth * j; v += half * j; a += t * j; }
        p[0] = x;
        p[1] = v;
        if (order > 2) p[2] = a;
        if (order > 3) p[3] = j;
        const double e = z[i * stride] - x;
        innovation[i * stride] = e;
        x += k0 * e;
        v += k1 * e;
        if (order > 2) a += k2 * e;
        if (order > 3) j += k3 * e;
        s[0] = x;
        s[1] = v;
        if (order > 2) s[2] = a;
        if (order > 3) s[3] = j;
    }
}

/* z (n, axes); predicted and smoothed (axes, n, order), innovation (n, axes), made here. */
Track run_track(long order, long n, long axes, const double *z, double t, const double *g)
{
    Track made = {malloc(axes * n * order * sizeof(double)), malloc(axes * n * order * sizeof(double)),
                  malloc(axes * n * sizeof(double))};
    for (long a = 0; a < axes; a++) {
        double *p = made.predicted + a * n * order, *s = made.smoothed + a * n * order;
        if (order == 2) track(2, n, axes, z + a, t, g, p, s, made.innovation + a);
        else if (order == 3) track(3, n, axes, z + a, t, g, p, s, made.innovation + a);
        else track(4, n, axes, z + a, t, g, p, s, made.innovation + a);
    }
    return made;
}

void free_track(Track made)
{
    free(made.predicted);
    free(made.smoothed);
    free(made.innovation);
}

/* ---------------------------------------------------------------- a map: many alpha-beta filters, one run */

/* Estimation RMSE of m gain sets (m, 2) on z and truth (n, axes); start by two points. */
void map_rmse(long m, long n, long axes, const double *restrict z, const double *restrict truth, double t,
              const double *restrict gains, double *restrict rmse)
{
    for (long first = 0; first < m; first += LANES) {
        const long filled = m - first < LANES ? m - first : LANES;
        double k0[LANES], k1[LANES], x[3][LANES], v[3][LANES], sum[LANES];
        for (int l = 0; l < LANES; l++) {
            const double *g = gains + 2 * (first + (l < filled ? l : 0));
            k0[l] = g[0];
            k1[l] = g[1] / t;
            sum[l] = 0;
        }
        for (long a = 0; a < axes; a++)
            for (int l = 0; l < LANES; l++) {
                const double d0 = z[a] - truth[a], d1 = z[axes + a] - truth[axes + a];
                x[a][l] = z[axes + a];
                v[a][l] = (z[axes + a] - z[a]) / t;
                sum[l] += d0 * d0 + d1 * d1;
            }
        for (long i = 2; i < n; i++)
            for (long a = 0; a < axes; a++) {
                const double seen = z[i * axes + a], there = truth[i * axes + a];
                for (int l = 0; l < LANES; l++) {
                    const double p = x[a][l] + t * v[a][l], e = seen - p, s = p + k0[l] * e, d = s - there;
                    x[a][l] = s;
                    v[a][l] += k1[l] * e;
                    sum[l] += d * d;
                }
            }
        for (long l = 0; l < filled; l++) rmse[first + l] = sqrt(sum[l] / n);
    }
}

/* ---------------------------------------------------------------- Monte Carlo: many runs, a few filters */

typedef struct {
    double total[3][LANES], square[3][LANES], greatest[3][LANES];
} Sums;

/* One filter on LANES runs z (n, axes, LANES) of one truth (n, axes), from the same known state (axes, 4). */
INLINE void lanes(const int order, long n, long axes, const double *restrict z, const double *restrict truth, double t,
                  const double *g, const double *state, Sums *restrict sums)
{
    const double half = t * t / 2, sixth = t * t * t / 6;
    const double k0 = g[0], k1 = g[1] / t, k2 = order > 2 ? g[2] / (t * t) : 0, k3 = order > 3 ? g[3] / (t * t * t) : 0;
    double x[3][LANES], v[3][LANES], acc[3][LANES], jerk[3][LANES], joint[3][LANES];
    memset(sums, 0, sizeof *sums);
    for (long a = 0; a < axes; a++)
        for (int l = 0; l < LANES; l++) {
            x[a][l] = state[4 * a];
            v[a][l] = state[4 * a + 1];
            acc[a][l] = state[4 * a + 2];
            jerk[a][l] = state[4 * a + 3];
        }
    for (long i = 0; i < n; i++) {
        memset(joint, 0, sizeof joint);
        for (long a = 0; a < axes; a++) {
            const double there = truth[i * axes + a];
            const double *seen = z + (i * axes + a) * LANES;
            for (int l = 0; l < LANES; l++) {
                double p = x[a][l] + t * v[a][l], w = v[a][l], c = acc[a][l];
                if (order > 2) { p += half * c; w += t * c; }
                if (order > 3) { p += sixth * jerk[a][l]; w += half * jerk[a][l]; c += t * jerk[a][l]; }
                const double e = seen[l] - p, s = p + k0 * e, before = p - there, after = s - there;
                joint[0][l] += before * before;
                joint[1][l] += after * after;
                joint[2][l] += e * e;
                x[a][l] = s;
                v[a][l] = w + k1 * e;
                if (order > 2) acc[a][l] = c + k2 * e;
                if (order > 3) jerk[a][l] += k3 * e;
            }
        }
        for (int kind = 0; kind < 3; kind++)
            for (int l = 0; l < LANES; l++) {
                const double q = joint[kind][l];
                sums->square[kind][l] += q;
                sums->total[kind][l] += sqrt(q);
                sums->greatest[kind][l] = q > sums->greatest[kind][l] ? q : sums->greatest[kind][l];
            }
    }
}

/* Total, RMSE, greatest and L2 of tracking, estimation and innovation: out (filters, runs, 3, 4).
 * z (runs, n, axes), truth (n, axes), gains (filters, 4) with orders, state (axes, 4) before the first sample. */
void monte_carlo(long runs, long n, long axes, long filters, const double *z, const double *truth, double t,
                 const double *gains, const long *orders, const double *state, double *out)
{
    double *tile = malloc(n * axes * LANES * sizeof(double));
    Sums sums;
    double before[4 * 3];
    for (long first = 0; first < runs; first += LANES) {
        const long filled = runs - first < LANES ? runs - first : LANES;
        for (int l = 0; l < LANES; l++) {
            const double *run = z + (first + (l < filled ? l : 0)) * n * axes;
            for (long i = 0; i < n * axes; i++) tile[i * LANES + l] = run[i];
        }
        for (long f = 0; f < filters; f++) {
            const double *g = gains + 4 * f;
            for (long a = 0; a < axes; a++)
                for (int r = 0; r < 4; r++) before[4 * a + r] = r < orders[f] ? state[4 * a + r] : 0;
            if (orders[f] == 2) lanes(2, n, axes, tile, truth, t, g, before, &sums);
            else if (orders[f] == 3) lanes(3, n, axes, tile, truth, t, g, before, &sums);
            else lanes(4, n, axes, tile, truth, t, g, before, &sums);
            for (long l = 0; l < filled; l++)
                for (int kind = 0; kind < 3; kind++) {
                    double *o = out + ((f * runs + first + l) * 3 + kind) * 4;
                    o[0] = sums.total[kind][l];
                    o[1] = sqrt(sums.square[kind][l] / n);
                    o[2] = sqrt(sums.greatest[kind][l]);
                    o[3] = sqrt(sums.square[kind][l]) / n;
                }
        }
    }
    free(tile);
}

/* ---------------------------------------------------------------- the search at every sample, order 4 */

/* Of the gain sets (sets, 4) the one whose state number `which` comes nearest to the truth, per axis and sample; of
 * equals the first. Only the distinct values of that gain are looked at, each with the first set that has it. z and truth
 * of that state (n, axes); start by two points; predicted and smoothed (axes, n, 4). */
void sample_search(long sets, long which, long n, long axes, const double *z, const double *wanted, double t,
                   const double *gains, double *predicted, double *smoothed)
{
    const double half = t * t / 2, sixth = t * t * t / 6;
    double *value = malloc(sets * sizeof(double));
    long *set = malloc(sets * sizeof(long)), distinct = 0;
    for (long k = 0; k < sets; k++) {
        int known = 0;
        for (long m = 0; m < distinct && !known; m++) known = value[m] == gains[4 * k + which];
        if (!known) {
            value[distinct] = gains[4 * k + which];
            set[distinct++] = k;
        }
    }
    for (long a = 0; a < axes; a++) {
        double *p = predicted + a * n * 4, *s = smoothed + a * n * 4;
        double x[4] = {z[axes + a], (z[axes + a] - z[a]) / t, 0, 0};
        for (long i = 2; i < n; i++) {
            x[0] += t * x[1] + half * x[2] + sixth * x[3];
            x[1] += t * x[2] + half * x[3];
            x[2] += t * x[3];
            memcpy(p + 4 * i, x, sizeof x);
            const double e = z[i * axes + a] - x[0], base = x[which], goal = wanted[i * axes + a];
            double step = e;
            for (long r = 0; r < which; r++) step /= t;
            double least = INFINITY;
            long best = 0;
            for (long k = 0; k < distinct; k++) {
                const double miss = fabs(base + value[k] * step - goal);
                if (miss < least) {
                    least = miss;
                    best = k;
                }
            }
            const double *g = gains + 4 * set[best];
            x[0] += g[0] * e;
            x[1] += g[1] / t * e;
            x[2] += g[2] / (t * t) * e;
            x[3] += g[3] / (t * t * t) * e;
            memcpy(s + 4 * i, x, sizeof x);
        }
    }
    free(value);
    free(set);
}
