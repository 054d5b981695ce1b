/* The evaluator's work as a hand-written loop, float32; c_peer.py builds and calls it.
 *
 * Individuals lie in the fastest axis (structure of arrays). A block of BLOCK of them runs through
 * all samples before the next block starts, so that its tables and state, 16 KB, stay in the
 * first-level cache; blocks are spread over the cores. Every inner loop runs over the individuals
 * of a block and is vector code, expf included (libmvec). Blocks of 16, 32 and 64 are equally
 * fast; 16 gives both cores work at 30 individuals.
 */
#include <math.h>
#include <stddef.h>

enum { BLOCK = 16, INPUTS = 5, UNITS = 4, TERMS = 7, SOURCES = INPUTS + UNITS };

#define INLINE static inline __attribute__((always_inline))
#define EACH for (int p = 0; p < BLOCK; p++)

typedef float row[BLOCK] __attribute__((aligned(64)));

/* The fields of Machine in work.py. */
struct machine {
    float current_decay, back_emf, inverse_inductance, torque_constant, inverse_rotor_inertia,
        inverse_spindle_inertia, rotor_damping, stiffness, gear_ratio, bristle_stiffness,
        bristle_damping, viscous_friction, coulomb_torque, stribeck_rise,
        inverse_stribeck_velocity;
};

struct constants {
    float sample_time, output_scale, error_weight, error_rate_weight;
};

struct state {
    float current, rotor_angle, rotor_velocity, spindle_angle, spindle_velocity, bristle;
};

/* A private copy of the individuals of a block, and what they remember between samples. */
struct block {
    row kp, kd, scales[INPUTS], consequents[UNITS * TERMS * TERMS];
    int sources[UNITS * 2][BLOCK];
    row current, rotor_angle, rotor_velocity, spindle_angle, spindle_velocity, bristle;
    row previous_velocity, error_sum, error_rate_sum;
    row values[SOURCES]; /* the scaled inputs, then the outputs of the units */
};

#ifdef OWN_EXP
/* The evaluator's exponential (bell in plants/blocks.py), of 2: a polynomial and an exponent. */
#define IN_BASE 1.44269504f
INLINE float decay(float power) {
    power = power > -127.0f ? power : -127.0f;
    float whole = rintf(power), rest = power - whole;
    float value = 0.00132029823f * rest + 0.00967495193f;
    value = ((value * rest + 0.0555104738f) * rest + 0.24022166f) * rest + 0.693146596f;
    union { float number; int bits; } result = {value * rest + 1.0f};
    result.bits += (int)whole << 23;
    return result.number;
}
#else
#define IN_BASE 1.0f
INLINE float decay(float power) { return expf(power); }
#endif

INLINE float clamped(float x) { return fminf(fmaxf(x, -1.0f), 1.0f); }

/* Exponent of a membership (eq. 3), in the base of decay. */
INLINE float exponent(float u, float centre, float half_width, float rate) {
    float outside = fmaxf(fabsf(u - centre) - half_width, 0.0f);
    return -IN_BASE * rate * outside * outside;
}

/* Rates of the state (Lin & Lee 1999, eq. 2). */
INLINE struct state derivative(struct machine m, struct state x, float voltage, float load) {
    float spring = m.stiffness * (x.rotor_angle - m.gear_ratio * x.spindle_angle);
    float relative = x.spindle_velocity * m.inverse_stribeck_velocity;
    float steady = m.coulomb_torque + m.stribeck_rise * decay(-IN_BASE * relative * relative);
    float bent = fabsf(x.spindle_velocity) * m.bristle_stiffness * x.bristle;
    float bristle = x.spindle_velocity - bent / steady;
    float friction = m.bristle_stiffness * x.bristle + m.bristle_damping * bristle +
                     m.viscous_friction * x.spindle_velocity;
    float motor = m.torque_constant * x.current - spring - m.rotor_damping * x.rotor_velocity;
    float cut = m.gear_ratio * spring - friction - load;
    float current = m.inverse_inductance * voltage - m.current_decay * x.current -
                    m.back_emf * x.rotor_velocity;
    return (struct state){current, x.rotor_velocity, m.inverse_rotor_inertia * motor,
                          x.spindle_velocity, m.inverse_spindle_inertia * cut, bristle};
}

INLINE struct state moved(struct state x, struct state rate, float time) {
    return (struct state){x.current + time * rate.current,
                          x.rotor_angle + time * rate.rotor_angle,
                          x.rotor_velocity + time * rate.rotor_velocity,
                          x.spindle_angle + time * rate.spindle_angle,
                          x.spindle_velocity + time * rate.spindle_velocity,
                          x.bristle + time * rate.bristle};
}

/* One classical Runge-Kutta step of dt seconds. */
INLINE struct state rk4(struct machine m, struct state x, float voltage, const float load[3],
                        float dt) {
    struct state rate = derivative(m, x, voltage, load[0]);
    struct state end = moved(x, rate, dt / 6.0f);
    rate = derivative(m, moved(x, rate, 0.5f * dt), voltage, load[1]);
    end = moved(end, rate, dt / 3.0f);
    rate = derivative(m, moved(x, rate, 0.5f * dt), voltage, load[1]);
    end = moved(end, rate, dt / 3.0f);
    rate = derivative(m, moved(x, rate, dt), voltage, load[2]);
    return moved(end, rate, dt / 6.0f);
}

/* Output of unit k from the two sources that each individual's own tree names (eq. 4). */
INLINE void infer(struct block *b, int k, const float terms[3][TERMS]) {
    row column, line, degrees[2 * TERMS], weighted;
#pragma omp simd
    EACH {
        float x = b->values[0][p], y = x;
        for (int s = 1; s < INPUTS + k; s++) {
            x = b->sources[2 * k][p] == s ? b->values[s][p] : x;
            y = b->sources[2 * k + 1][p] == s ? b->values[s][p] : y;
        }
        column[p] = x, line[p] = y, weighted[p] = 0.0f;
    }
    for (int i = 0; i < TERMS; i++) {
#pragma omp simd
        EACH {
            degrees[i][p] = exponent(column[p], terms[0][i], terms[1][i], terms[2][i]);
            degrees[TERMS + i][p] = exponent(line[p], terms[0][i], terms[1][i], terms[2][i]);
        }
    }
    float *flat = degrees[0];
#pragma omp simd
    for (int p = 0; p < 2 * TERMS * BLOCK; p++) flat[p] = decay(flat[p]);
    row *c = degrees, *r = degrees + TERMS;
    for (int i = 0; i < TERMS; i++) {
        const row *w = b->consequents + (k * TERMS + i) * TERMS;
#pragma omp simd
        EACH weighted[p] += r[i][p] * (c[0][p] * w[0][p] + c[1][p] * w[1][p] + c[2][p] * w[2][p] +
                                       c[3][p] * w[3][p] + c[4][p] * w[4][p] + c[5][p] * w[5][p] +
                                       c[6][p] * w[6][p]);
    }
#pragma omp simd
    EACH {
        float in_column = c[0][p] + c[1][p] + c[2][p] + c[3][p] + c[4][p] + c[5][p] + c[6][p];
        float in_row = r[0][p] + r[1][p] + r[2][p] + r[3][p] + r[4][p] + r[5][p] + r[6][p];
        b->values[INPUTS + k][p] = weighted[p] / (in_column * in_row);
    }
}

/* One control sample of a block: measure, infer, hold the voltage, move. */
INLINE void sample(struct block *b, struct machine m, struct constants c,
                   const float terms[3][TERMS], float reference, float reference_rate,
                   const float load[3]) {
#pragma omp simd
    EACH {
        float deflection = b->rotor_angle[p] - m.gear_ratio * b->spindle_angle[p];
        float deflection_rate = b->rotor_velocity[p] - m.gear_ratio * b->spindle_velocity[p];
        b->values[0][p] = clamped(b->scales[0][p] * (reference - b->spindle_angle[p]));
        b->values[1][p] = clamped(b->scales[1][p] * deflection);
        b->values[2][p] = clamped(b->scales[2][p] * deflection_rate);
        b->values[3][p] = clamped(b->scales[3][p] * b->spindle_velocity[p]);
        b->values[4][p] = clamped(b->scales[4][p] * b->previous_velocity[p]);
    }
    for (int k = 0; k < UNITS; k++) infer(b, k, terms); /* unrolled it is slower */
#pragma omp simd
    EACH {
        struct state x = {b->current[p],       b->rotor_angle[p],      b->rotor_velocity[p],
                          b->spindle_angle[p], b->spindle_velocity[p], b->bristle[p]};
        float error = reference - x.spindle_angle;
        float error_rate = reference_rate - x.spindle_velocity;
        float voltage = b->kp[p] * error + b->kd[p] * error_rate +
                        c.output_scale * b->values[SOURCES - 1][p];
        b->error_sum[p] += fabsf(error);
        b->error_rate_sum[p] += fabsf(error_rate);
        b->previous_velocity[p] = x.spindle_velocity;
        x = rk4(m, x, voltage, load, c.sample_time);
        b->current[p] = x.current;
        b->rotor_angle[p] = x.rotor_angle;
        b->rotor_velocity[p] = x.rotor_velocity;
        b->spindle_angle[p] = x.spindle_angle;
        b->spindle_velocity[p] = x.spindle_velocity;
        b->bristle[p] = x.bristle;
    }
}

/* found[n]: score of every individual; the arguments between are the fields of Work in work.py. */
void scores(int n, int samples, const float *kp, const float *kd, const float *scales,
            const int *sources, const float *consequents, const float *reference,
            const float *reference_rate, const float *loads, const float terms[3][TERMS],
            const struct machine *machine, const struct constants *constants, float *found) {
#pragma omp parallel for schedule(dynamic)
    for (int start = 0; start < n; start += BLOCK) {
        struct block b = {0};
        EACH {
            size_t from = start + p < n ? start + p : n - 1; /* fills up a short last block */
            b.kp[p] = kp[from], b.kd[p] = kd[from];
            for (int i = 0; i < INPUTS; i++) b.scales[i][p] = scales[(size_t)i * n + from];
            for (int i = 0; i < UNITS * 2; i++) b.sources[i][p] = sources[(size_t)i * n + from];
            for (int i = 0; i < UNITS * TERMS * TERMS; i++)
                b.consequents[i][p] = consequents[(size_t)i * n + from];
        }
        for (int s = 0; s < samples; s++) {
            float load[3] = {loads[s], loads[samples + s], loads[2 * samples + s]};
            sample(&b, *machine, *constants, terms, reference[s], reference_rate[s], load);
        }
        for (int p = 0; p < BLOCK && start + p < n; p++)
            found[start + p] = 1000.0f * (constants->error_weight / b.error_sum[p] +
                                          constants->error_rate_weight / b.error_rate_sum[p]);
    }
}
