/* The stick-ratio regulator of one finger, in single precision. @origin@

   Forces in N, moves in mm, readings in microstrain, in the order of the gages. See regulator.c. */

#ifndef REGULATOR_H
#define REGULATOR_H

@sizes@

/* What the rig has measured of its finger; it stays where it is while the regulator runs.
   Tables of readings hold a row of all gages for each force. */
typedef struct {
    int points;
    const float *normal_force; /* rising */
    const float *pressed;      /* readings under it alone */
    const float *sticking;     /* readings per N of F_t, where nothing slips */
    const float *approach;     /* of the press, rising */
    const float *stiffness;    /* dF_t/dx where nothing slips, N/mm */
    float cross_talk;          /* what is felt as F_t of each newton of F_n; 0 where unknown */
    const float *turn_radius;  /* mm; 0 of a cell that does not measure torque */
} regulator_curves;

typedef struct {
    float dx, dy;      /* the next move: toward +x, and closing */
    float stick_ratio; /* stick area / contact area */
    float used;        /* F_t / (mu F_n) */
    float friction;    /* mu; 0 before anything is known of it */
    int unsure;        /* 1 while that is little */
} regulator_command;

/* What was felt, and the move that led to it. */
typedef struct {
    float readings[REGULATOR_GAGES];
    float normal_force, tangential_force, dx, dy;
} regulator_moment;

/* All that is remembered of a grip; nobody else's to change. */
typedef struct {
    regulator_curves curves;
    regulator_moment history[REGULATOR_LOOKS_BACK + 1]; /* the last one first */
    int moments, begun, pulled;
    int dead[REGULATOR_GAGES];
    regulator_moment start; /* the last before the first pull */
    float touch[REGULATOR_GAGES], since[4];
    float unfelt_dx[REGULATOR_MOST_DELAY + 1], unfelt_dy[REGULATOR_MOST_DELAY + 1];
    int delay, settling;
    float torque, arm_moment, arm_force;
    float stiffness, pressing, used, probed, most, carried;
    float weight, sum, forces;       /* of the friction's samples */
    float exponent, first_force, first_friction; /* first: at the first probe's end */
} regulator;

/* Begin a grip at its preload. delay: samples from a move until it is felt; stiffness: dF_t/dx at
   the preload, N/mm. 1, where they or the curves cannot be; else 0. */
int regulator_init(regulator *r, const regulator_curves *curves, int delay, float stiffness);

/* The torque of the next step's sample, N mm: about the normal, +y through the contact's middle. Call
   it before each step where the force cell has six axes. */
void regulator_torque(regulator *r, float torque);

/* The next move, of what is felt now; lifted: the object has left its support. 1, and no move,
   where a number is not finite: the sample is passed over. Else 0. */
int regulator_step(regulator *r, const float readings[REGULATOR_GAGES], float normal_force,
                   float tangential_force, int lifted, regulator_command *command);

#endif
