#include <archive/import/order.hpp>
#include <array>
#include <cmath>
#include <cstdio>

namespace downrange::archive {
namespace {

/// Receivers' clocks step back by seconds now and then: the service's ingest judges that.
constexpr double usual_step_back_s = 60;

struct Period {
  double period_s;
  double tolerance_s;
  const char* name;
  const char* key;
};
constexpr std::array<Period, 2> periods{
    {{86'400, 3600, "midnight", "wrap_s = 86400"}, {604'800, 3600, "the end of a week", "wrap_s = 604800"}}};

std::string show(double seconds) {
  std::array<char, 40> text{};
  std::snprintf(text.data(), text.size(), "%.3f s", seconds);
  return text.data();
}

std::string at_line(std::uint64_t line) { return "line " + std::to_string(line); }

}  // namespace

std::string order_problem(const FileMapping& mapping, const std::vector<RowTimes>& rows) {
  std::uint64_t forward = 0;
  std::uint64_t backward = 0;
  std::uint64_t first_backward = 0;
  const RowTimes* farthest_back = nullptr;
  double farthest_s = 0;
  for (std::size_t i = 1; i < rows.size(); ++i) {
    const double step_s = (rows[i].epoch - rows[i - 1].epoch).seconds();
    const double received_step_s = (rows[i].received - rows[i - 1].received).seconds();
    if (step_s > 0) ++forward;
    if (step_s < 0 && ++backward == 1) first_backward = rows[i].line;
    if (step_s < farthest_s) {
      farthest_s = step_s;
      farthest_back = &rows[i];
    }
    if (mapping.wrap) continue;
    for (const Period& period : periods) {
      const double back_s = std::abs(std::min(step_s, received_step_s));
      if (step_s >= 0 && received_step_s >= 0) continue;
      if (std::abs(back_s - period.period_s) > period.tolerance_s) continue;
      return at_line(rows[i].line) + " is " + show(back_s) + " before the row before: time starts anew at " +
             period.name + "? Write " + period.key + " to continue it, or wrap_s = 0 to take it as it is";
    }
  }
  if (mapping.sort || mapping.kind == FileKind::Truth) return {};
  constexpr const char* remedy = "; write sort = true to sort the rows, or sort = false to take them as they stand";
  if (backward > forward && backward > 1) {
    return std::string(backward > 10 * forward ? "the rows are newest first ("
                                               : "the rows are not in order of time (") +
           std::to_string(backward) + " of " + std::to_string(backward + forward) +
           " steps back in time, the first at " + at_line(first_backward) + ")" + remedy;
  }
  if (mapping.latency && farthest_s < -usual_step_back_s) {
    return "the rows are not in order of time: " + at_line(farthest_back->line) + " is " + show(-farthest_s) +
           " before the row before, and no column says when it was received" + remedy;
  }
  return {};
}

}  // namespace downrange::archive
