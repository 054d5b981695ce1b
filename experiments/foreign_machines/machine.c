/* A servo axis of one or two masses and a mode, simulated in short fixed steps (C99, SI units).
 *
 * It has its own friction, gap, drive and encoders, and nothing of the package, so that designs
 * meet a machine that is not quite their model. From textbooks: two masses behind a spring with
 * a gap (Nordin & Gutman, Automatica 38, 2002), friction as one elasto-slip element whose slip
 * force falls with the speed (Iwan 1966; Al-Bender, Lampaert & Swevers, IEEE TAC 50, 2005),
 * the classical Runge-Kutta method. Lengths are those of the load: [m], of a rotary axis [rad].
 */
#include <math.h>
#include <stdint.h>

#define PI 3.14159265358979323846

typedef struct {
    double motor_inertia;     /* [kg m2], of a linear motor [kg] */
    double ratio;             /* way of the load for a radian of the motor [m] */
    double load_mass;         /* [kg], rotary [kg m2] */
    double stiffness;         /* between motor and load [N/m]; 0: they are one mass */
    double damping;           /* of the same [N s/m] */
    double gap;               /* from flank to flank [m] */
    double pull;              /* of gravity less counterweight, positive pulls back [N] */
    double coulomb;           /* friction of the load when it slides [N] */
    double breakaway;         /* the same at rest [N] */
    double stribeck_speed;    /* at which the difference has fallen to 1/e [m/s] */
    double presliding;        /* way until friction is fully there [m] */
    double viscous;           /* of the load [N s/m] */
    double motor_coulomb;     /* of motor and bearings [N m] */
    double motor_viscous;     /* of the same [N m s/rad] */
    double mode_mass;         /* swings on the load [kg] */
    double mode_hz;           /* held at its foot */
    double mode_damping;      /* share of critical */
    double cogging;           /* amplitude [N] */
    double cogging_pitch;     /* [m] */
    double gain;              /* of drive and motor [N m/V] */
    double command_limit;     /* [V] */
    double torque_limit;      /* [N m] */
    double lag_s;             /* of the current loop */
    double delay_s;           /* until a command acts; any, in steps of the integration */
    double load_encoder;      /* step of the scale [m]; 0: ideal */
    double motor_encoder;     /* step in way of the load [m]; 0: ideal */
    double noise;             /* standard deviation of a reading [m] */
    double fed_back;          /* 0: the scale at the load, 1: the encoder at the motor */
    double offset;            /* reading less reference at the start [m] */
    double seed;              /* of the noise */
} machine;

/* How a control forms its velocities. */
typedef struct {
    double observer_hz;       /* of a tracking observer; 0: a difference */
    double difference_samples;
    double unit;              /* units of the control in a metre */
} sensing;

/* The present loop: a PID with what is fed forward, in units of the control. */
typedef struct {
    double kp, ki, kd, filter_s, speed, acceleration, bias;
} pid_gains;

enum { SIGNALS = 11, COLUMNS = 5, STATES = 9, LONGEST = 4096 };
/* Of signals: error, error_rate, position, velocity, motor_position, motor_velocity, and the
 * reference with its rate and acceleration, the load's place and rate by its scale; of columns: what is fed back, its reading, the motor's
 * reading, the command, the other mass' place. */
typedef double (*law)(const double *signals);

enum { MOTOR, MOTOR_SPEED, LOAD, LOAD_SPEED, BEND, MOTOR_BEND, TORQUE, MODE, MODE_SPEED };

static double bound(double x, double most) { return x > most ? most : x < -most ? -most : x; }

/* The slip force of the slides at a speed [N]. */
static double slip(const machine *m, double speed)
{
    const double u = m->stribeck_speed > 0 ? speed / m->stribeck_speed : 0;
    return m->coulomb + (m->breakaway - m->coulomb) * exp(-u * u);
}

/* The force of an elasto-slip element bent by ``z``, whose rate goes to ``rate``. */
static double rub(double z, double v, double most, double way, double mass, double *rate)
{
    *rate = 0;
    if (most <= 0) {
        return 0;
    }
    const double stiffness = most / way;
    const int slides = fabs(z) >= way && z * v > 0;
    if (slides) {
        return z > 0 ? most : -most;
    }
    *rate = v;
    return stiffness * bound(z, way) + bound(0.4 * sqrt(stiffness * mass) * v, most);
}

static void slope(const machine *m, const double *x, double command, double *dx)
{
    const double moved = m->motor_inertia / (m->ratio * m->ratio); /* the motor at the load */
    const double rigid = m->stiffness <= 0;
    const double mass = rigid ? moved + m->load_mass : m->load_mass;
    const double own = 2 * PI * m->mode_hz; /* of the mode [rad/s] */
    const double torque = m->lag_s > 0 ? x[TORQUE] : bound(m->gain * command, m->torque_limit);
    double drive = torque / m->ratio - m->motor_viscous * x[MOTOR_SPEED] / (m->ratio * m->ratio);
    double force = -m->pull - m->viscous * x[LOAD_SPEED];
    const double swing = own * own * (x[MODE] - x[LOAD])
        + 2 * m->mode_damping * own * (x[MODE_SPEED] - x[LOAD_SPEED]);
    force += m->mode_mass * swing;
    if (m->cogging_pitch > 0) {
        force += m->cogging * sin(2 * PI * x[LOAD] / m->cogging_pitch);
    }
    force -= rub(x[BEND], x[LOAD_SPEED], slip(m, x[LOAD_SPEED]), m->presliding, mass, &dx[BEND]);
    drive -= rub(x[MOTOR_BEND], x[MOTOR_SPEED], m->motor_coulomb / m->ratio, m->presliding,
        rigid ? mass : moved, &dx[MOTOR_BEND]);
    dx[MOTOR] = x[MOTOR_SPEED];
    dx[LOAD] = x[LOAD_SPEED];
    dx[MODE] = x[MODE_SPEED];
    dx[MODE_SPEED] = -swing;
    dx[TORQUE] = m->lag_s > 0
        ? (bound(m->gain * command, m->torque_limit) - x[TORQUE]) / m->lag_s : 0;
    if (rigid) {
        dx[MOTOR_SPEED] = dx[LOAD_SPEED] = (drive + force) / mass;
        return;
    }
    const double wound = x[MOTOR] - x[LOAD];
    const double bent = wound - bound(wound, 0.5 * m->gap);
    double spring = m->stiffness * bent + m->damping * (x[MOTOR_SPEED] - x[LOAD_SPEED]);
    if (m->gap > 0 && spring * bent <= 0) {
        spring = 0; /* a flank pushes only */
    }
    dx[MOTOR_SPEED] = (drive - spring) / moved;
    dx[LOAD_SPEED] = (force + spring) / m->load_mass;
}

/* One step of the classical Runge-Kutta method. */
static void step(const machine *m, double *x, double command, double dt)
{
    static const double part[4] = { 0, 0.5, 0.5, 1 }, weight[4] = { 1, 2, 2, 1 };
    double sum[STATES] = { 0 }, dx[STATES] = { 0 }, at[STATES];
    for (int stage = 0; stage < 4; stage++) {
        for (int i = 0; i < STATES; i++) {
            at[i] = x[i] + part[stage] * dt * dx[i];
        }
        slope(m, at, command, dx);
        for (int i = 0; i < STATES; i++) {
            sum[i] += weight[stage] * dx[i];
        }
    }
    for (int i = 0; i < STATES; i++) {
        x[i] += dt / 6 * sum[i];
    }
    x[BEND] = bound(x[BEND], m->presliding);
    x[MOTOR_BEND] = bound(x[MOTOR_BEND], m->presliding);
}

/* A normal deviate: the sum of twelve uniform ones less their mean (xorshift of Marsaglia). */
static double normal(uint64_t *state)
{
    double sum = -6;
    for (int i = 0; i < 12; i++) {
        *state ^= *state << 13;
        *state ^= *state >> 7;
        *state ^= *state << 17;
        sum += (double)(*state >> 11) / 9007199254740992.0;
    }
    return sum;
}

static double counted(double place, double step)
{
    return step > 0 ? step * floor(place / step + 0.5) : place;
}

/* A velocity from readings: a tracking observer, critically damped, or a difference. */
typedef struct {
    double past[64], place, rate;
} track;

static double velocity(track *t, const sensing *s, double reading, double sample_time)
{
    if (s->observer_hz > 0) {
        const double p = exp(-2 * PI * s->observer_hz * sample_time);
        const double ahead = t->place + sample_time * t->rate;
        t->rate += (1 - p) * (1 - p) * (reading - ahead) / sample_time;
        t->place = ahead + (1 - p * p) * (reading - ahead);
        return t->rate;
    }
    const int back = (int)s->difference_samples;
    for (int i = 63; i > 0; i--) {
        t->past[i] = t->past[i - 1];
    }
    t->past[0] = reading;
    return (reading - t->past[back]) / (back * sample_time);
}

static pid_gains present;
static double integral, slow_rate, pid_time, pid_limit;

/* The present loop's law; run() sets it up. */
double pid(const double *signals)
{
    const double a = present.filter_s > 0 ? pid_time / (pid_time + present.filter_s) : 1;
    slow_rate += a * (signals[1] - slow_rate);
    const double u = present.kp * signals[0] + integral + present.kd * slow_rate + present.bias
        + present.speed * signals[7] + present.acceleration * signals[8];
    if (fabs(u) < pid_limit || u * signals[0] < 0) {
        integral += present.ki * pid_time * signals[0];
    }
    return bound(u, pid_limit);
}

/* Run a loop of ``samples`` and leave ``COLUMNS`` of each in ``out``, in units of the control.
 *
 * ``reference`` has place, rate and acceleration of each sample, ``added`` comes to the command.
 * A command that is no number ends the run. Returns the samples that were run.
 */
int run(const machine *m, const sensing *s, const pid_gains *gains, law control, int samples,
    double sample_time, int steps, const double *reference, const double *added, double *out)
{
    static double sent[LONGEST];
    const int late = (int)floor(m->delay_s / sample_time * steps + 0.5);
    const double dt = sample_time / steps, hangs = m->stiffness > 0 ? m->pull / m->stiffness : 0;
    double x[STATES] = { 0 };
    uint64_t random = 88172645463325252ULL + 7919ULL * (uint64_t)m->seed;
    track tracks[2] = { 0 };
    present = *gains;
    integral = slow_rate = 0;
    pid_time = sample_time;
    pid_limit = m->command_limit;
    /* A brake has held the motor; the load hangs on its spring. */
    x[MOTOR] = hangs + (m->pull > 0 ? 0.5 : m->pull < 0 ? -0.5 : 0) * m->gap;
    const double zero = x[MOTOR];
    for (int n = 0; n < samples; n++) {
        const double *r = reference + 3 * n;
        double read[2];
        for (int i = 0; i < 2; i++) {
            const double place = i ? x[MOTOR] - zero : x[LOAD];
            const double grain = i ? m->motor_encoder : m->load_encoder;
            read[i] = s->unit * counted(place + m->offset + m->noise * normal(&random), grain);
            if (n == 0) {
                tracks[i].place = read[i];
                for (int k = 0; k < 64; k++) {
                    tracks[i].past[k] = read[i];
                }
            }
        }
        const double rates[2] = { velocity(&tracks[0], s, read[0], sample_time),
            velocity(&tracks[1], s, read[1], sample_time) };
        const int f = m->fed_back > 0;
        const double signals[SIGNALS] = { r[0] - read[f], r[1] - rates[f], read[f], rates[f],
            read[1], rates[1], r[0], r[1], r[2], read[0], rates[0] };
        const double u = control(signals);
        if (!isfinite(u)) {
            return n;
        }
        sent[n % LONGEST] = bound(u + added[n], m->command_limit);
        double *row = out + COLUMNS * n;
        row[0] = s->unit * ((f ? x[MOTOR] - zero : x[LOAD]) + m->offset);
        row[1] = read[f];
        row[2] = read[1];
        row[3] = sent[n % LONGEST];
        row[4] = s->unit * ((f ? x[LOAD] : x[MOTOR] - zero) + m->offset);
        for (int i = 0; i < steps; i++) {
            const int acts = n * steps + i - late;
            step(m, x, acts < 0 ? 0 : sent[acts / steps % LONGEST], dt);
        }
    }
    return samples;
}
