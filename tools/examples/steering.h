/* What an antenna does with commands, whatever DDS they came by: it moves on between them, stops when they end, and
 * tells where it points.
 *
 * Commands come 40 times a second, ahead of the instant at which they apply; a servo wants a position more often than
 * that, and for the instant at which it will be there. Between two commands both are carried to that instant, to second
 * order where they have accelerations, and weighed by how near they are; behind the newest that one is carried on.
 * Nothing is followed after its valid_until. Plain C, so that both antenna clients share it. */
#ifndef DOWNRANGE_EXAMPLE_STEERING_H
#define DOWNRANGE_EXAMPLE_STEERING_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum {
  steering_room = 256,          /* commands on their way: the 2 s of steering_ahead_max_ms at up to 128 Hz */
  steering_ahead_max_ms = 2000, /* a command further ahead is of a clock that is wrong, and would outrank all others */
  servo_lag_ms = 50,            /* what the servo is told now it reaches so much later: lead_ms of [[antenna]] */
  servo_step_ms = 10,
  report_every = 10 /* steps */
};

struct steering_command {
  int64_t tick_ns; /* names the command in our reports */
  int64_t apply_at_ns;
  int64_t valid_until_ns;
  double azimuth_rad; /* unwrapped: from one command to the next it never jumps, but to go around */
  double elevation_rad;
  double azimuth_rate_rad_s;
  double elevation_rate_rad_s;
  bool acceleration_valid; /* else the next two say nothing */
  double azimuth_acceleration_rad_s2;
  double elevation_acceleration_rad_s2;
};

struct steering {
  struct steering_command command[steering_room]; /* ascending in apply_at_ns */
  int count;
};

/* Where the axes shall be at an instant, and by which command. */
struct steering_aim {
  double azimuth_rad;
  double elevation_rad;
  int64_t tick_ns;
};

static inline bool steering_sound(const struct steering_command* c) {
  return isfinite(c->azimuth_rad) && isfinite(c->elevation_rad) && isfinite(c->azimuth_rate_rad_s) &&
         isfinite(c->elevation_rate_rad_s) &&
         (!c->acceleration_valid ||
          (isfinite(c->azimuth_acceleration_rad_s2) && isfinite(c->elevation_acceleration_rad_s2)));
}

/* A command that applies no later than one we have is old news. */
static inline void steering_take(struct steering* s, struct steering_command c, int64_t now_ns) {
  if (!steering_sound(&c) || c.apply_at_ns > now_ns + steering_ahead_max_ms * INT64_C(1000000)) return;
  if (s->count > 0 && c.apply_at_ns <= s->command[s->count - 1].apply_at_ns) return;
  if (s->count == steering_room) {
    memmove(&s->command[0], &s->command[1], (steering_room - 1) * sizeof s->command[0]);
    --s->count;
  }
  s->command[s->count++] = c;
}

static inline struct steering_aim steering_carry(const struct steering_command* c, int64_t at_ns, bool second_order) {
  const double dt = (double)(at_ns - c->apply_at_ns) * 1e-9;
  struct steering_aim aim = {c->azimuth_rad + dt * c->azimuth_rate_rad_s,
                             c->elevation_rad + dt * c->elevation_rate_rad_s, c->tick_ns};
  if (second_order) {
    aim.azimuth_rad += 0.5 * dt * dt * c->azimuth_acceleration_rad_s2;
    aim.elevation_rad += 0.5 * dt * dt * c->elevation_acceleration_rad_s2;
  }
  return aim;
}

/* Where the axes shall be at an instant. False: there is no command to follow, stand still. */
static inline bool steering_at(const struct steering* s, int64_t at_ns, struct steering_aim* aim) {
  int i = s->count - 1;
  while (i >= 0 && s->command[i].apply_at_ns > at_ns) --i;
  if (i < 0 || at_ns > s->command[i].valid_until_ns) return false;
  const struct steering_command* from = &s->command[i];
  *aim = steering_carry(from, at_ns, from->acceleration_valid);
  if (i + 1 == s->count) return true;
  const struct steering_command* to = &s->command[i + 1];
  if (fabs(to->azimuth_rad - from->azimuth_rad) > 3) return true; /* it goes around: not by way of the middle */
  const double part = (double)(at_ns - from->apply_at_ns) / (double)(to->apply_at_ns - from->apply_at_ns);
  if (from->acceleration_valid && to->acceleration_valid) {
    const struct steering_aim next = steering_carry(to, at_ns, true);
    aim->azimuth_rad += part * (next.azimuth_rad - aim->azimuth_rad);
    aim->elevation_rad += part * (next.elevation_rad - aim->elevation_rad);
  } else { /* straight from one to the other is as near as two tangents */
    aim->azimuth_rad = from->azimuth_rad + part * (to->azimuth_rad - from->azimuth_rad);
    aim->elevation_rad = from->elevation_rad + part * (to->elevation_rad - from->elevation_rad);
  }
  return true;
}

static inline int64_t utc_now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* An antenna's axes, made up: they lag behind what they are told by servo_lag_ms. Your servo and encoders take its
 * place. */
struct mount {
  bool follows; /* else it stands still */
  bool pointed; /* it was told where to point at all: there it begins */
  double azimuth_rad;
  double elevation_rad;
  int64_t tick_ns; /* of the command that it follows; 0: none */
};

/* One step of the antenna's control loop, every servo_step_ms. Prints twice a second, and when it stops. */
static inline void mount_step(struct mount* m, const struct steering* s, int64_t now_ns, int step) {
  struct steering_aim aim;
  const bool followed = m->follows;
  m->follows = steering_at(s, now_ns + servo_lag_ms * INT64_C(1000000), &aim);
  m->tick_ns = m->follows ? aim.tick_ns : 0;
  if (m->follows) {
    const double part = m->pointed ? 1 - exp(-(double)servo_step_ms / (double)servo_lag_ms) : 1;
    m->azimuth_rad += part * (aim.azimuth_rad - m->azimuth_rad);
    m->elevation_rad += part * (aim.elevation_rad - m->elevation_rad);
    m->pointed = true;
  }
  if (m->follows && step % 50 == 0) {
    printf("azimuth %8.4f deg, elevation %8.4f deg\n", m->azimuth_rad * 57.29577951308232,
           m->elevation_rad * 57.29577951308232);
  } else if (followed && !m->follows) {
    printf("no valid command: standing still\n");
  }
  fflush(stdout);
}

#endif
