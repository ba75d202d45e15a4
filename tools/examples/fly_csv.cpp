// fly_csv FOLDER: flies the CSV files of a folder (radar.csv, gps.csv) through the engine, and prints once a second
// where the vehicle is and where the antenna shall point.

#include <cmath>
#include <cstdio>
#include <downrange/stage/engine.hpp>
#include <exception>

#include "csv_flight.hpp"

namespace {

using namespace downrange;

// Receives what the engine makes of the flight. Keeps the newest trajectory and command.
class Screen final : public ResultSink {
 public:
  void emit(const Result& result) override {
    if (const auto* trajectory = std::get_if<Trajectory>(&result)) trajectory_ = *trajectory;
    if (const auto* command = std::get_if<SlavingCommand>(&result)) command_ = *command;
    if (const auto* observation = std::get_if<Observation>(&result))
      rejected_ += observation->verdict != Reason::Accepted;
  }

  void print(double t_s) const {
    // A fixed-size state: what is its 1-sigma position error, over all axes?
    const auto& P = trajectory_.covariance;  // upper triangle, row by row: the diagonal is at 0, n, 2n - 1
    const auto n = static_cast<std::size_t>(trajectory_.state_size);
    const double sigma_m = std::sqrt(P[0] + P[n] + P[2 * n - 1]);
    std::printf("T+%4.1f  %8.4f %9.4f  %7.3f km  %6.1f m/s  1-sigma %5.1f m   antenna %7.3f %6.3f deg\n", t_s,
                trajectory_.geodetic.latitude_rad / example::deg, trajectory_.geodetic.longitude_rad / example::deg,
                trajectory_.geodetic.height_m / 1000, trajectory_.speed_m_s, sigma_m,
                command_.azimuth_rad / example::deg, command_.elevation_rad / example::deg);
  }
  int rejected() const { return rejected_; }

 private:
  Trajectory trajectory_;
  SlavingCommand command_;
  int rejected_ = 0;
};

void fly(const char* folder) {
  Screen screen;
  Engine engine(example::example_range(), StageSet{}, screen);
  double shown_s = 0;
  for (const Event& event : example::read_flight(folder)) {
    // The engine runs the ticks before an event by itself. `admit` gives what a recorder would write.
    engine.handle(engine.admit(event));
    const double t_s = (received_of(event) - example::liftoff).seconds();
    if (t_s < shown_s + 1) continue;
    shown_s = std::floor(t_s);
    screen.print(t_s);
  }
  std::printf("%d observations rejected\n", screen.rejected());
}

}  // namespace

int main(int argc, char** argv) {
  if (argc != 2) {
    std::fprintf(stderr, "usage: %s FOLDER\n", argv[0]);
    return 2;
  }
  try {
    fly(argv[1]);
  } catch (const std::exception& error) {
    std::fprintf(stderr, "%s\n", error.what());
    return 1;
  }
  return 0;
}
