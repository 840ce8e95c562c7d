/* The stick-ratio regulator of one finger, in single precision. @origin@

   The same as fingerdesign's control/features.py, control/estimator.py and
   control/controllers/regulator.py, which state the reasons. Without contraction (gcc -std=c99)
   and without -ffast-math it gives the same bits anywhere. */

#include "regulator.h"

#include <math.h>
#include <stdint.h>
#include <string.h>

#define GAGES REGULATOR_GAGES
#define LANES 16
#define MOST_TURNS 50   /* of conjugate gradients: they are near after some ten */
#define ENOUGH 1e-12f   /* of the first error's square: as near as singles are */
#define KINDS COUNT(READINGS_AT)
#define COUNT(array) ((int)(sizeof(array) / sizeof *(array)))

typedef struct {
    int inputs, outputs;
    const int16_t *weight; /* a row of all outputs for each input */
    const float *scale;    /* of each output's weights */
    const float *bias;
} layer;

@numbers@

typedef struct {
    float stick_ratio, used, spread;
} estimate;

static float larger(float a, float b) { return b > a ? b : a; }
static float smaller(float a, float b) { return b < a ? b : a; }

/* Natural logarithm of x > 0, by 2 artanh((m - 1) / (m + 1)): the same bits in every library. */
static float logarithm(float x) {
    int power;
    float m = frexpf(x, &power), s, q, series;
    if (m < 0.70710678f) {
        m = m + m;
        power -= 1;
    }
    s = (m - 1.0f) / (m + 1.0f);
    q = s * s;
    series = 1.0f + q * (0.33333333f + q * (0.2f + q * (0.14285714f + q * 0.11111111f)));
    return 2.0f * s * series + 0.69314718f * (float)power;
}

/* The interval of rising values in which x lies; x comes back within their ends. */
static int place(const float *values, int count, float *x, float *share) {
    int k = 0, end = count - 1;
    *x = smaller(larger(*x, values[0]), values[end]);
    while (end - k > 1) {
        int middle = (k + end) / 2;
        if (values[middle] < *x)
            k = middle;
        else
            end = middle;
    }
    *share = (*x - values[k]) / (values[k + 1] - values[k]);
    return k;
}

static float between(const float *y, float share, int stride) {
    return y[0] + share * (y[stride] - y[0]);
}

static float interpolated(float x, const float *xs, const float *ys, int count) {
    float share;
    int k = place(xs, count, &x, &share);
    return between(ys + k, share, 1);
}

static void row_at(const regulator_curves *c, const float *table, float force, float *row) {
    float share;
    int k = place(c->normal_force, c->points, &force, &share), g;
    for (g = 0; g < GAGES; g++)
        row[g] = between(table + k * GAGES + g, share, GAGES);
}

/* Share of the stiffness that an object leaves which turns about its centre of mass. */
static float left_by_turn(const regulator *r, float force) {
    const regulator_curves *c = &r->curves;
    float radius, part;
    if (!c->turn_radius)
        return 1.0f;
    radius = interpolated(force, c->normal_force, c->turn_radius, c->points);
    if (!(radius > 0.0f))
        return 1.0f;
    part = r->arm_moment / (r->arm_force + ARM_FORCE * ARM_FORCE) / radius;
    return 1.0f / (1.0f + part * part);
}

/* Adds a move to a way: along x, closing, and the lengths of both. */
static void go(float *way, const regulator_moment *move) {
    way[0] += move->dx;
    way[1] += move->dy;
    way[2] += fabsf(move->dx);
    way[3] += fabsf(move->dy);
}

/* Features of the change since a moment, and the way since: the gages', then seven of the forces
   and moves. */
static float *changes(const regulator *r, const regulator_moment *before, const float *moved,
                      const float *alone, float scale, float pressed, float *out) {
    const regulator_curves *c = &r->curves;
    const regulator_moment *now = r->history;
    float way = larger(moved[2] + moved[3], LEAST_MOTION), from[GAGES];
    float rise, pull, size, after, middle, rising, pulling;
    int g;
    after = interpolated(before->normal_force, c->normal_force, c->approach, c->points) + moved[1];
    after = interpolated(after, c->approach, c->normal_force, c->points);
    rising = after - before->normal_force;
    middle = 0.5f * (before->normal_force + after);
    pulling = interpolated(middle, c->normal_force, c->stiffness, c->points);
    pulling = pulling * left_by_turn(r, middle) * moved[0];
    rise = now->normal_force - before->normal_force;
    pull = now->tangential_force - before->tangential_force;
    size = fabsf(pull) + NORMAL_SHARE * fabsf(rise) + LEAST_CHANGE;
    row_at(c, c->pressed, before->normal_force, from);
    for (g = 0; g < GAGES; g++)
        *out++ = (now->readings[g] - before->readings[g] - (alone[g] - from[g])) / (scale * size);
    *out++ = rise / size;
    *out++ = pull / size;
    *out++ = (rise - rising) / size;
    *out++ = (pull - pulling) / size;
    *out++ = moved[0] / way;
    *out++ = logarithm(way);
    *out++ = logarithm(size / pressed);
    return out;
}

/* Which gages have answered to nothing since a moment at which they should have: they are left out.
   alone: what a press alone would cause now. */
static void find_dead(regulator *r, const float *alone) {
    int g, k;
    for (g = 0; g < GAGES; g++) {
        if (r->moments >= REGULATOR_SILENT && fabsf(alone[g]) > HEARD * NOTHING)
            r->dead[g] = 1;
        for (k = 0; k < REGULATOR_SILENT; k++)
            if (!(fabsf(r->history[k].readings[g]) < NOTHING))
                r->dead[g] = 0;
    }
}

/* FEATURES numbers of the last moment: the present, the changes over the last steps and since the
   first pull, the touch. */
static void features(regulator *r, float *out) {
    const regulator_moment *now = r->history;
    float pressed = larger(now->normal_force, LEAST_FORCE), scale = 0.0f;
    float alone[GAGES], sticking[GAGES], *present = out;
    int g, k;
    row_at(&r->curves, r->curves.pressed, pressed, alone);
    row_at(&r->curves, r->curves.sticking, pressed, sticking);
    for (g = 0; g < GAGES; g++)
        scale = larger(scale, fabsf(sticking[g]));
    scale = larger(scale, LEAST_RESPONSE);
    find_dead(r, alone);
    for (g = 0; g < GAGES; g++)
        *out++ = (now->readings[g] - alone[g]) / (scale * pressed);
    *out++ = logarithm(pressed);
    *out++ = now->tangential_force / pressed;
    *out++ = LOG_NOISE;
    r->most = larger(r->most, now->tangential_force / pressed);
    *out++ = r->most;
    *out++ = left_by_turn(r, pressed);
    for (k = 0; k < COUNT(LAGS); k++) {
        int first = LAGS[k] < r->moments - 1 ? LAGS[k] : r->moments - 1, i;
        float moved[4] = {0.0f, 0.0f, 0.0f, 0.0f};
        for (i = first - 1; i >= 0; i--)
            go(moved, now + i);
        out = changes(r, now + first, moved, alone, scale, pressed, out);
    }
    r->pulled = r->pulled || now->dx != 0.0f;
    if (r->pulled)
        go(r->since, now);
    else {
        r->start = *now;
        memcpy(r->touch, present, sizeof r->touch);
    }
    out = changes(r, &r->start, r->since, alone, scale, pressed, out);
    memcpy(out, r->touch, sizeof r->touch);
}

/* Weighted sums of outputs o to o + LANES - 1, in registers: half the time of sums in memory. */
static void add_up(const layer *l, const float *values, int o, float *sums) {
#define EACH(do) do(0) do(1) do(2) do(3) do(4) do(5) do(6) do(7) do(8) do(9) do(10) do(11) do(12) \
    do(13) do(14) do(15)
#define BEGIN(k) float s##k = 0.0f;
#define ADD(k) s##k += v * (float)w[k];
#define END(k) sums[k] = s##k;
    const float *end = values + l->inputs;
    const int16_t *w = l->weight + o;
    EACH(BEGIN)
    for (; values < end; values++, w += l->outputs) {
        float v = *values;
        if (v != 0.0f) {
            EACH(ADD)
        }
    }
    EACH(END)
}

/* How two features go together: control/completion.py. */
static float related(int i, int j) {
    if (i == j)
        return 1.0f;
    return (float)RELATED[i > j ? i * (i - 1) / 2 + j : j * (j - 1) / 2 + i] / 32767.0f;
}

/* The features of dead gages from all others, by conjugate gradients. */
static void complete(const regulator *r, float *values) {
    float found[KINDS * GAGES], left[KINDS * GAGES], way[KINDS * GAGES], turned[KINDS * GAGES];
    float size = 0.0f, first, before, step;
    int places[KINDS * GAGES], count = 0, g, i, k, n;
    for (g = 0; g < GAGES; g++)
        for (k = 0; k < KINDS; k++)
            if (r->dead[g]) {
                places[count] = READINGS_AT[k] + g;
                values[places[count++]] = 0.0f;
            }
    for (n = 0; n < count; n++) {
        for (left[n] = found[n] = 0.0f, i = 0; i < FEATURES; i++)
            left[n] -= related(places[n], i) * (ROOT[i] * values[i]);
        way[n] = left[n];
        size += left[n] * left[n];
    }
    first = size;
    for (k = 0; k < MOST_TURNS && size > ENOUGH * first; k++) {
        float along = 0.0f;
        for (n = 0; n < count; n++) {
            for (turned[n] = 0.0f, i = 0; i < count; i++)
                turned[n] += related(places[n], places[i]) * way[i];
            along += way[n] * turned[n];
        }
        step = size / along;
        before = size;
        for (size = 0.0f, n = 0; n < count; n++) {
            found[n] += step * way[n];
            left[n] -= step * turned[n];
            size += left[n] * left[n];
        }
        for (n = 0; n < count; n++)
            way[n] = left[n] + size / before * way[n];
    }
    for (n = 0; n < count; n++)
        values[places[n]] = smaller(larger(found[n] / ROOT[places[n]], -OUTLIER), OUTLIER);
}

static estimate estimated(regulator *r) {
    float values[WIDEST], sums[WIDEST];
    estimate found;
    int n, i, o, k;
    features(r, values);
    for (i = 0; i < FEATURES; i++)
        values[i] = smaller(larger((values[i] - CENTER[i]) / SCALE[i], -OUTLIER), OUTLIER);
    complete(r, values);
    for (n = 0; n < COUNT(LAYERS); n++) {
        const layer *l = LAYERS + n;
        for (o = 0; o + LANES <= l->outputs; o += LANES)
            add_up(l, values, o, sums + o);
        for (; o < l->outputs; o++)
            for (sums[o] = 0.0f, i = 0; i < l->inputs; i++)
                sums[o] += values[i] * (float)l->weight[i * l->outputs + o];
        for (o = 0; o < l->outputs; o++) {
            values[o] = l->scale[o] * sums[o] + l->bias[o];
            if (n + 1 < COUNT(LAYERS))
                values[o] = larger(values[o], 0.0f);
        }
    }
    found.stick_ratio = smaller(larger(values[0], 0.0f), 1.0f);
    found.used = smaller(larger(values[1], 0.0f), 1.0f);
    for (k = 0; k + 1 < COUNT(SPREAD) && SPREAD[k][0] < values[2]; k++)
        ;
    found.spread = SPREAD[k][1];
    return found;
}

/* dF_t/dx and dF_n/dy as last felt; shears too small to be felt teach nothing. */
static void learn_stiffness(regulator *r) {
    const regulator_moment *now = r->history, *before = now + 1;
    float rise = now->normal_force - before->normal_force;
    float change = now->tangential_force - before->tangential_force;
    if (now->dy > 0.0f && rise > 0.0f)
        r->pressing = rise / now->dy;
    if (now->dx > 0.02f * SHEAR_STEP && change > 0.0f)
        r->stiffness = STIFFNESS_FADES * r->stiffness
                       + (1.0f - STIFFNESS_FADES) * change / now->dx;
}

static void learn_friction(regulator *r, estimate found) {
    const regulator_moment *now = r->history;
    float friction, sure, memory = MEMORY;
    if (!r->pulled || found.used < LEAST_USED || now->normal_force < 2.0f * LEAST_FORCE)
        return;
    friction = now->tangential_force / (now->normal_force * found.used);
    friction = smaller(larger(friction, LEAST_FRICTION), MOST_FRICTION);
    sure = found.used / larger(found.spread, 1e-3f);
    sure = sure * sure;
    if (now->dy > 0.0f) {
        sure = CLIMBING * sure;
        memory = 1.0f - CLIMBING * (1.0f - memory);
    }
    r->weight = memory * r->weight + sure;
    r->sum = memory * r->sum + sure * friction;
    r->forces = memory * r->forces + sure * now->normal_force;
}

/* dy of the next step; half of the largest before the finger's stiffness has been felt. */
static float closing(const regulator *r, float pressed) {
    if (!(r->pressing > 0.0f))
        return 0.5f * APPROACH_STEP;
    return smaller(APPROACH_STEP,
                   larger(PRESS_SHARE * pressed / r->pressing, 0.1f * APPROACH_STEP));
}

static float shear(const regulator *r, float force) {
    return smaller(larger(force / r->stiffness, 0.0f), SHEAR_STEP);
}

/* The friction at a normal force; 0 before anything is known. */
static float friction_at(const regulator *r, float force) {
    float mean, both, off;
    if (!(r->weight > 0.0f))
        return 0.0f;
    mean = r->forces / r->weight;
    both = mean + force;
    off = r->exponent * (mean - force);
    return r->sum / r->weight * ((both + off) / (both - off));
}

static void probe_ends(regulator *r, float pressed) {
    float force = r->forces / r->weight, friction = friction_at(r, force), found;
    if (r->probed != 0.0f)
        return;
    r->probed = pressed;
    if (friction == 0.0f)
        return;
    if (r->first_force == 0.0f) {
        r->first_force = force;
        r->first_friction = friction;
    }
    force = logarithm(force / r->first_force);
    friction = logarithm(r->first_friction / friction);
    found = PRIOR * EXPONENT + 0.5f * force * friction;
    found = found / (PRIOR + 0.5f * force * force);
    r->exponent = smaller(larger(found, 0.0f), MOST_EXPONENT);
}

/* The friction less its standard deviation. */
static float surely(const regulator *r, float force) {
    return friction_at(r, force) * larger(1.0f - CAUTION / sqrtf(r->weight), 0.5f);
}

/* The next move, of forces as they will be. */
static void next(regulator *r, estimate found, float normal, float tangential, int lifted,
                 regulator_command *to) {
    float pressed = larger(normal, LEAST_FORCE), ratio = tangential / pressed;
    float friction = friction_at(r, pressed);
    int known = friction > 0.0f;
    float believed = known ? ratio / friction : 0.0f;
    to->dx = to->dy = 0.0f;
    if (lifted) {
        if (r->carried == 0.0f)
            r->carried = ratio;
        if (ratio / (known ? surely(r, pressed) : UNKNOWN) > MOST_HELD
            || ratio > TUGGED * r->carried)
            to->dy = closing(r, pressed);
        return;
    }
    r->used += NEWS * (found.used - r->used);
    if (found.stick_ratio < LEAST_STICK || larger(r->used, believed) > MOST_USED) {
        probe_ends(r, pressed);
        to->dy = closing(r, pressed);
        return;
    }
    if (r->probed > 0.0f && pressed > AGAIN * r->probed) {
        r->probed = 0.0f;
        r->weight *= KEPT;
        r->sum *= KEPT;
        r->forces *= KEPT;
    }
    if (r->probed == 0.0f) {
        float room, unfelt = larger(ratio - r->history->tangential_force / pressed, 0.0f);
        if (pressed < PROBE_FORCE_N) {
            to->dy = closing(r, pressed);
            return;
        }
        unfelt = known ? unfelt / friction : 0.0f;
        room = NEAR * TARGET - r->used - unfelt;
        if (room > 0.0f) {
            float step = PULL_SHARE * pressed / sqrtf((float)(1 + r->delay));
            if (known)
                step = larger(smaller(step, OF_ROOM * room * friction * pressed),
                              SLOWEST * step);
            to->dx = shear(r, step);
            return;
        }
        probe_ends(r, pressed);
    }
    if (known) {
        to->dy = closing(r, pressed);
        pressed += larger(r->pressing, 0.0f) * to->dy;
        to->dx = shear(r, TARGET * surely(r, pressed) * pressed - tangential);
    } else
        to->dx = shear(r, PULL_SHARE * pressed);
}

static void remember(regulator *r, const float *readings, float normal, float tangential, float dx,
                     float dy) {
    regulator_moment *now = r->history;
    int k;
    for (k = REGULATOR_LOOKS_BACK; k > 0; k--)
        now[k] = now[k - 1];
    memcpy(now->readings, readings, sizeof now->readings);
    now->normal_force = normal;
    now->tangential_force = tangential;
    now->dx = dx;
    now->dy = dy;
    r->arm_moment += r->torque * tangential;
    r->arm_force += tangential * tangential;
    if (r->moments <= REGULATOR_LOOKS_BACK)
        r->moments++;
}

int regulator_init(regulator *r, const regulator_curves *curves, int delay, float stiffness) {
    float finite = stiffness - stiffness + (curves->cross_talk - curves->cross_talk);
    int k;
    if (curves->points < 2 || delay < 0 || delay > REGULATOR_MOST_DELAY || !(stiffness > 0.0f))
        return 1;
    for (k = 1; k < curves->points; k++)
        if (!(curves->normal_force[k] > curves->normal_force[k - 1]
              && curves->approach[k] > curves->approach[k - 1]))
            return 1;
    for (k = 0; k < curves->points; k++) {
        finite += curves->normal_force[k] - curves->normal_force[k];
        finite += curves->approach[k] - curves->approach[k];
        finite += curves->stiffness[k] - curves->stiffness[k];
        if (curves->turn_radius)
            finite += curves->turn_radius[k] - curves->turn_radius[k];
    }
    for (k = 0; k < curves->points * GAGES; k++) {
        finite += curves->pressed[k] - curves->pressed[k];
        finite += curves->sticking[k] - curves->sticking[k];
    }
    if (finite != 0.0f)
        return 1;
    memset(r, 0, sizeof *r);
    r->curves = *curves;
    r->delay = r->settling = delay;
    r->stiffness = stiffness;
    r->exponent = EXPONENT;
    return 0;
}

void regulator_torque(regulator *r, float torque) { r->torque = torque; }

/* A sample that is passed over was of a move, which the next one answers too; none follows it. */
static void miss(regulator *r) {
    int k;
    if (r->settling > 0) {
        r->settling--;
        return;
    }
    if (r->delay == 0)
        return;
    r->unfelt_dx[1] += r->unfelt_dx[0];
    r->unfelt_dy[1] += r->unfelt_dy[0];
    for (k = 0; k < r->delay; k++) {
        r->unfelt_dx[k] = r->unfelt_dx[k + 1];
        r->unfelt_dy[k] = r->unfelt_dy[k + 1];
    }
    r->unfelt_dx[r->delay] = r->unfelt_dy[r->delay] = 0.0f;
}

int regulator_step(regulator *r, const float readings[GAGES], float normal_force,
                   float tangential_force, int lifted, regulator_command *command) {
    float dx = 0.0f, dy = 0.0f, finite = normal_force - normal_force;
    int k, settles = r->settling > 0;
    estimate found;
    memset(command, 0, sizeof *command);
    finite += tangential_force - tangential_force + (r->torque - r->torque);
    for (k = 0; k < GAGES; k++)
        finite += readings[k] - readings[k];
    if (finite != 0.0f) { /* an infinite number or none, less itself, is none */
        r->torque = 0.0f;
        miss(r);
        return 1;
    }
    tangential_force -= r->curves.cross_talk * normal_force;
    if (settles || !r->begun) { /* all before was of the press */
        r->moments = 0;
        r->arm_moment = r->arm_force = 0.0f;
        remember(r, readings, normal_force, tangential_force, 0.0f, 0.0f);
        r->begun = 1;
        r->most = 0.0f;
    }
    if (settles)
        r->settling--;
    else {
        remember(r, readings, normal_force, tangential_force, r->unfelt_dx[0], r->unfelt_dy[0]);
        learn_stiffness(r);
    }
    r->torque = 0.0f;
    found = estimated(r);
    command->stick_ratio = found.stick_ratio;
    command->used = found.used;
    command->unsure = 1;
    if (settles)
        return 0;
    if (!lifted)
        learn_friction(r, found);
    for (k = 0; k < r->delay; k++) { /* moves on their way */
        r->unfelt_dx[k] = r->unfelt_dx[k + 1];
        r->unfelt_dy[k] = r->unfelt_dy[k + 1];
        dx += r->unfelt_dx[k];
        dy += r->unfelt_dy[k];
    }
    next(r, found, normal_force + r->pressing * dy, tangential_force + r->stiffness * dx, lifted,
         command);
    r->unfelt_dx[r->delay] = command->dx;
    r->unfelt_dy[r->delay] = command->dy;
    command->unsure = r->weight < SURE;
    if (r->weight > 0.0f)
        command->friction = r->sum / r->weight;
    return 0;
}
