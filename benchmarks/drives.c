/* One axis of a population under PID control as a hand-written loop, float32; drives.py calls it.
 *
 * The same steps as plants/five_axis.py and plants/milling_table.py take: a servo drive that stops
 * at its time, and two bodies behind backlash by the implicit midpoint rule. Machines lie in the
 * fastest axis, a block of them runs through all samples before the next one, blocks are spread
 * over the cores, and every inner loop runs over a block and is vector code.
 */
#include <tgmath.h>

#ifdef DOUBLE /* to be checked */
typedef double real;
#else
typedef float real;
#endif

#define R(number) ((real)(number))

enum { BLOCK = 64, INNER = 16 };

#define INLINE static inline __attribute__((always_inline))
#define EACH for (int p = 0; p < BLOCK; p++)
#define LANES _Pragma("omp simd") EACH

typedef real row[BLOCK] __attribute__((aligned(64)));

/* What both loops have: PID on the counted position, its integral held at the limit. */
struct control {
    real sample_time, limit, count, start;
};
struct pid {
    row kp, ki, kd, before, sum;
};

INLINE real clipped(real x, real most) { return fmin(fmax(x, -most), most); }

INLINE real command(struct pid *c, int p, struct control k, real error) {
    const real sum = c->sum[p] + error, rate = (error - c->before[p]) / k.sample_time;
    const real rest = c->kp[p] * error + c->kd[p] * rate, step = c->ki[p] * k.sample_time;
    const real first = rest + step * sum;
    const int held = fabs(first) > k.limit && first * error > R(0.0);
    c->sum[p] = held ? c->sum[p] : sum;
    c->before[p] = error;
    return clipped(rest + step * c->sum[p], k.limit);
}

INLINE void begun(struct pid *c, const real *gains, int count, int first) {
    EACH {
        const int own = first + p < count ? first + p : count - 1;
        c->kp[p] = gains[own], c->ki[p] = gains[count + own], c->kd[p] = gains[2 * count + own];
        c->before[p] = c->sum[p] = R(0.0);
    }
}

/* Fields of ServoCoefficients, as far as a step needs them. */
struct servo {
    real gain, time_constant, stiffness, coulomb, rise, inverse_stribeck, peak, velocity_per_volt;
};

INLINE real servo_friction(struct servo c, real speed) {
    const real relative = speed * c.inverse_stribeck;
    return c.coulomb + c.rise * exp(-relative * relative);
}

/* In one direction for `time`, or until it stops: see _leg of plants/sliding.py. */
INLINE real leg(struct servo c, real *position, real *velocity, real drive, real time) {
    const real x = *position, v = *velocity;
    const int sticks = v == R(0.0) && fabs(drive) <= c.coulomb + c.rise;
    const real towards = v == R(0.0) ? drive : v;
    const real direction = towards > R(0.0) ? R(1.0) : towards < R(0.0) ? -R(1.0) : R(0.0);
    const real settled = R(1.0) - exp(-time / c.time_constant);
    const real before = servo_friction(c, fabs(v));
    real target = c.gain * (drive - direction * before);
    const real foreseen = fmax(direction * (v + (target - v) * settled), R(0.0));
    target = c.gain * (drive - direction * R(0.5) * (before + servo_friction(c, foreseen)));
    real change = (target - v) * settled;
    const int stops = (v + change) * direction < R(0.0);
    const real until = c.time_constant * log(R(1.0) - v / (stops ? target : R(1.0)));
    const real duration = stops ? until : time;
    change = stops ? -v : change;
    *position = sticks ? x : x + target * duration - c.time_constant * change;
    *velocity = sticks ? v : stops ? R(0.0) : v + change;
    return !sticks && stops ? time - duration : R(0.0);
}

/* Mean squares of the error of `count` axes over `samples`, by their gains (3, count). */
void servo(int count, int samples, const real *reference, const real *gains,
           const struct servo *parameters, const struct control *control, real *found) {
    const struct servo c = *parameters;
    const struct control k = *control;
    const real most = c.peak / c.stiffness * (k.sample_time / c.time_constant) /
                       (R(1.0) - exp(-k.sample_time / c.time_constant));
#pragma omp parallel for schedule(dynamic)
    for (int first = 0; first < count; first += BLOCK) {
        struct pid own;
        row x, v, squares;
        begun(&own, gains, count, first);
        EACH x[p] = k.start, v[p] = squares[p] = R(0.0);
        for (int i = 0; i < samples; i++) {
            LANES {
                const real off = reference[i] - x[p];
                const real seen = reference[i] - k.count * rint(x[p] / k.count);
                const real wanted = c.velocity_per_volt * command(&own, p, k, seen);
                const real drive = c.stiffness * (v[p] + clipped(wanted - v[p], most));
                squares[p] += off * off;
                const real left = leg(c, &x[p], &v[p], drive, k.sample_time);
                leg(c, &x[p], &v[p], drive, left);
            }
        }
        for (int p = 0; p < BLOCK && first + p < count; p++) {
            found[first + p] = squares[p] / (real)samples;
        }
    }
}

/* Joined of plants/backlash.py, and the force of a volt. */
struct table {
    real driving_mass, driving_damping, driving_friction, driven_mass, viscous, coulomb, rise,
        inverse_stribeck, stiffness, damping_time, half_gap, force_gain;
};

INLINE real beyond(real force, real friction) { return force - clipped(force, friction); }

struct body {
    real force, friction, slope;
};

INLINE void corner(real at, struct body other, real ease, real known, real *last,
                   real *above) {
    const real left = known + other.slope * beyond(other.force - at, other.friction) - ease * at;
    const real further = fmin(at - *last, left); /* both are positive: gcc's masks fail on && */
    *last = further > R(0.0) ? at : *last;
    *above = further > R(0.0) ? left : *above;
}

INLINE real fall(struct body b, real last) {
    const real beneath = last < b.force - b.friction ? b.slope : R(0.0);
    return last >= b.force + b.friction ? b.slope : beneath;
}

INLINE real spring(struct table c, real known, struct body a, struct body b) {
    real free = known + a.slope * beyond(a.force, a.friction) + b.slope * beyond(b.force, b.friction);
    const real side = free > R(0.0) ? R(1.0) : free < R(0.0) ? -R(1.0) : R(0.0);
    const real ease = R(1.0) / c.stiffness;
    a.force *= side, b.force *= side;
    known = side * known - c.half_gap, free = side * free - c.half_gap;
    real last = R(0.0), above = free;
    corner(a.force - a.friction, b, ease, known, &last, &above);
    corner(a.force + a.friction, b, ease, known, &last, &above);
    corner(b.force - b.friction, a, ease, known, &last, &above);
    corner(b.force + b.friction, a, ease, known, &last, &above);
    const real force = last + above / (ease + fall(a, last) + fall(b, last));
    return free <= R(0.0) ? R(0.0) : side * force;
}

void table(int count, int samples, const real *reference, const real *gains,
           const struct table *parameters, const struct control *control, real *found) {
    const struct table c = *parameters;
    const struct control k = *control;
    const real dt = k.sample_time / INNER, half = R(0.5) * (R(0.5) * dt + c.damping_time);
    const real driving = c.driving_mass / dt, driven = c.driven_mass / dt;
    const real driving_kept = driving - R(0.5) * c.driving_damping;
    const real driven_kept = driven - R(0.5) * c.viscous;
    const real driving_ease = R(1.0) / (driving + R(0.5) * c.driving_damping);
    const real driven_ease = R(1.0) / (driven + R(0.5) * c.viscous);
#pragma omp parallel for schedule(dynamic)
    for (int first = 0; first < count; first += BLOCK) {
        struct pid own;
        row x, v, motor, motor_v, before, bent, way, push, squares;
        begun(&own, gains, count, first);
        EACH x[p] = motor[p] = k.start, v[p] = motor_v[p] = squares[p] = R(0.0);
        for (int i = 0; i < samples; i++) {
            LANES {
                const real off = reference[i] - x[p];
                const real seen = reference[i] - k.count * rint(x[p] / k.count);
                push[p] = c.force_gain * command(&own, p, k, seen);
                squares[p] += off * off;
                bent[p] = motor[p] - x[p], way[p] = R(0.0), before[p] = v[p];
            }
            for (int inner = 0; inner < INNER; inner++) {
                LANES {
                    const real middle = v[p] == R(0.0) ? R(0.0) : R(1.5) * v[p] - R(0.5) * before[p];
                    const real relative = middle * c.inverse_stribeck;
                    const real friction = c.coulomb + c.rise * exp(-relative * relative);
                    const real pushed = driving_kept * motor_v[p] + push[p];
                    const real pulled = driven_kept * v[p];
                    const struct body a = {pushed, c.driving_friction, half * driving_ease};
                    const struct body b = {-pulled, friction, half * driven_ease};
                    const real force = spring(c, bent[p] + half * (motor_v[p] - v[p]), a, b);
                    const real ahead = driving_ease * beyond(pushed - force, c.driving_friction);
                    const real after = driven_ease * beyond(pulled + force, friction);
                    const real gone = R(0.5) * dt * (v[p] + after);
                    bent[p] += R(0.5) * dt * (motor_v[p] + ahead) - gone;
                    way[p] += gone, before[p] = v[p], motor_v[p] = ahead, v[p] = after;
                }
            }
            LANES {
                x[p] += way[p];
                motor[p] = x[p] + bent[p];
            }
        }
        for (int p = 0; p < BLOCK && first + p < count; p++) {
            found[first + p] = squares[p] / (real)samples;
        }
    }
}
