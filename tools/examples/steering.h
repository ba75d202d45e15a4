/* What an antenna does with commands, whatever DDS they came by: it moves on between them, and stops when they end.
 *
 * Commands come 40 times a second, ahead of the instant at which they apply; a servo wants a position more often than
 * that. Between two commands the axes go from one to the other, behind the newest at its rates; nothing is followed
 * after its valid_until. Plain C, so that both antenna clients share it. */
#ifndef DOWNRANGE_EXAMPLE_STEERING_H
#define DOWNRANGE_EXAMPLE_STEERING_H

#include <math.h>
#include <stdbool.h>
#include <stdint.h>
#include <stdio.h>
#include <string.h>
#include <time.h>

enum { steering_room = 16 }; /* commands on their way: 40 Hz x a lead of 0.4 s */

struct steering_command {
  int64_t apply_at_ns;
  int64_t valid_until_ns;
  double azimuth_rad; /* unwrapped: from one command to the next it never jumps, but to go around */
  double elevation_rad;
  double azimuth_rate_rad_s;
  double elevation_rate_rad_s;
};

struct steering {
  struct steering_command command[steering_room]; /* ascending in apply_at_ns */
  int count;
};

/* A command that applies no later than one we have is old news. */
static inline void steering_take(struct steering* s, struct steering_command c) {
  if (s->count > 0 && c.apply_at_ns <= s->command[s->count - 1].apply_at_ns) return;
  if (s->count == steering_room) {
    memmove(&s->command[0], &s->command[1], (steering_room - 1) * sizeof s->command[0]);
    --s->count;
  }
  s->command[s->count++] = c;
}

/* Where the axes shall be now. False: there is no command to follow, stand still. */
static inline bool steering_at(const struct steering* s, int64_t now_ns, double* azimuth_rad, double* elevation_rad) {
  int i = s->count - 1;
  while (i >= 0 && s->command[i].apply_at_ns > now_ns) --i;
  if (i < 0 || now_ns > s->command[i].valid_until_ns) return false;
  const struct steering_command* from = &s->command[i];
  const double since_s = (double)(now_ns - from->apply_at_ns) * 1e-9;
  *azimuth_rad = from->azimuth_rad + from->azimuth_rate_rad_s * since_s;
  *elevation_rad = from->elevation_rad + from->elevation_rate_rad_s * since_s;
  if (i + 1 == s->count) return true;
  const struct steering_command* to = &s->command[i + 1];
  if (fabs(to->azimuth_rad - from->azimuth_rad) > 3) return true; /* it goes around: not by way of the middle */
  const double part = since_s / ((double)(to->apply_at_ns - from->apply_at_ns) * 1e-9);
  *azimuth_rad = from->azimuth_rad + part * (to->azimuth_rad - from->azimuth_rad);
  *elevation_rad = from->elevation_rad + part * (to->elevation_rad - from->elevation_rad);
  return true;
}

static inline int64_t utc_now_ns(void) {
  struct timespec now;
  clock_gettime(CLOCK_REALTIME, &now);
  return (int64_t)now.tv_sec * 1000000000 + now.tv_nsec;
}

/* The antenna's control loop would move the axes here, every 10 ms. Prints twice a second, and when it stops; returns
 * whether it follows. */
static inline bool steering_step(const struct steering* s, bool followed, int step) {
  double azimuth_rad = 0;
  double elevation_rad = 0;
  const bool follows = steering_at(s, utc_now_ns(), &azimuth_rad, &elevation_rad);
  if (follows && step % 50 == 0) {
    printf("azimuth %8.4f deg, elevation %8.4f deg\n", azimuth_rad * 57.29577951308232,
           elevation_rad * 57.29577951308232);
  } else if (followed && !follows) {
    printf("no valid command: standing still\n");
  }
  fflush(stdout);
  return follows;
}

#endif
