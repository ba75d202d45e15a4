#pragma once
/// This machine's clock: UTC, and how well it is kept, as the kernel knows from whoever disciplines it (NTP, PTP).

#include <sys/timex.h>
#include <time.h>

#include <downrange/geo/time.hpp>

#include "dds/service_status.hpp"

namespace downrange::app {

[[nodiscard]] inline Time utc_now() {
  timespec now{};
  clock_gettime(CLOCK_REALTIME, &now);
  return {static_cast<std::int64_t>(now.tv_sec) * 1'000'000'000 + now.tv_nsec};
}

[[nodiscard]] inline dds::UtcState read_utc_state() {
  timex clock{};  // modes 0: reads only
  const int state = adjtimex(&clock);
  if (state < 0) return {};
  const double unit_s = (clock.status & STA_NANO) != 0 ? 1e-9 : 1e-6;
  return {.known = true,
          .synchronised = state != TIME_ERROR && (clock.status & STA_UNSYNC) == 0,
          .offset_s = static_cast<double>(clock.offset) * unit_s,
          .error_s = static_cast<double>(clock.maxerror) * 1e-6};
}

}  // namespace downrange::app
