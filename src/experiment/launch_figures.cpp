#include "experiment/launch_result.hpp"

#include <algorithm>
#include <numeric>

namespace downrange::experiment::launch {
namespace {

constexpr std::size_t boost = 0;
constexpr std::size_t late = 2;

std::string window_text(std::size_t w) { return ", " + windows()[w].name; }
std::string radar_text(std::size_t r) { return ", " + std::string(radar_names[r]); }

double position_ratio(const Score& a, const Score& b, std::size_t window) {
  return a.window[window].errors.position.rms() / b.window[window].errors.position.rms();
}

void bias_left_rows(std::vector<Figure>& out, const Flown* flown, const Score& bound, const std::string& what,
                    double limit) {
  if (flown == nullptr) return;
  for (std::size_t w = 0; w < windows().size(); ++w) {
    for (std::size_t r = 0; r < radars; ++r) {
      const auto left = [&](const Score& s) { return s.window[w].errors.bias_left[r].rms(); };
      out.push_back(at_most(what + window_text(w) + radar_text(r), left(flown->score) / left(bound), limit));
    }
  }
}

/// Convergence: the bias left in the second that begins 20 s after radars and GPS first saw the vehicle together.
void settled_rows(std::vector<Figure>& out, const Flown* flown) {
  if (flown == nullptr) return;
  for (std::size_t r = 0; r < radars; ++r)
    out.push_back(at_most(flown->contestant.label + ", bias left at 120 s, m" + radar_text(r),
                          flown->score.second[20].bias_left[r].rms(), 10));
}

void position_rows(std::vector<Figure>& out, const Flown* flown, const Score* other, const std::string& what,
                   const std::array<double, 3>& limits) {
  if (flown == nullptr || other == nullptr) return;
  for (std::size_t w = 0; w < windows().size(); ++w)
    out.push_back(at_most(what + window_text(w), position_ratio(flown->score, *other, w), limits[w]));
}

WindowScore all_windows(const Score& score) {
  return std::accumulate(score.window.begin(), score.window.end(), WindowScore{},
                         [](WindowScore sum, const WindowScore& w) { return sum += w; });
}

void consistency_rows(std::vector<Figure>& out, const Flown* flown, bool judged) {
  if (flown == nullptr) return;
  const WindowScore all = all_windows(flown->score);
  const auto row = [&](const std::string& what, const Share& share, double low, double high) {
    const std::string name = flown->contestant.label + ", " + what;
    out.push_back(judged ? within(name, share.value(), low, high) : shown(name, share.value()));
  };
  row("NIS inside 95 %", all.nis, 0.94, 0.96);
  row("error inside 2 sigma", all.two_sigma, 0.94, 0.98);
  row("bias NEES inside 95 %", all.bias_nees, 0.92, 0.98);
}

/// Greatest over least rms of the bias left by time since the last fix, in the boost window: where the vehicle
/// accelerates GPS predicted at constant velocity drifts off most, and the paper's fig. 5 shows it.
double ripple(const Score& score) {
  const auto& bins = score.window[boost].ripple;
  const auto smaller = [](const Squares& a, const Squares& b) { return a.rms() < b.rms(); };
  const auto [least, greatest] = std::minmax_element(bins.begin(), bins.end(), smaller);
  return greatest->rms() / least->rms();
}

const Score* score_of(const Flown* flown) { return flown == nullptr ? nullptr : &flown->score; }

}  // namespace

const Flown* Result::find(std::string_view label, Case which) const {
  const auto found = std::find_if(flown.begin(), flown.end(), [&](const Flown& f) {
    return f.contestant.label == label && f.contestant.which == which;
  });
  return found == flown.end() ? nullptr : &*found;
}

std::vector<Figure> figures(const Result& result) {
  const Flown* const joint = result.find("joint-ca");
  const Flown* const launch = result.find("joint-launch");
  const Flown* const schmidt = result.find("schmidt");
  const Flown* const song = result.find("song2015");
  const Flown* const uncorrected = result.find("uncorrected");
  std::vector<Figure> out;
  bias_left_rows(out, joint, result.bound, "joint-ca, bias left / bound", 1.10);
  bias_left_rows(out, schmidt, result.bound, "schmidt, bias left / bound", 1.10);
  settled_rows(out, joint);
  settled_rows(out, schmidt);

  position_rows(out, joint, &result.bound, "joint-ca, position / bound", {1.08, 1.08, 1.08});
  position_rows(out, joint, score_of(uncorrected), "joint-ca, position / uncorrected", {1.0 / 8, 1.0 / 20, 1.0 / 28});
  position_rows(out, joint, score_of(song), "joint-ca, position / song2015", {0.45, 0.55, 0.40});
  position_rows(out, launch, &result.bound, "joint-launch, position / bound of ca", {0.80, 0.42, 0.80});

  consistency_rows(out, joint, true);
  consistency_rows(out, launch, false);
  consistency_rows(out, schmidt, false);

  const Flown* const joint_lost = result.find("joint-ca", Case::GpsLost);
  const Flown* const song_lost = result.find("song2015", Case::GpsLost);
  if (joint_lost != nullptr)
    out.push_back(at_most("GPS lost at 370 s: joint-ca, position / bound, late",
                          position_ratio(joint_lost->score, result.bound_gps_lost, late), 1.08));
  if (joint_lost != nullptr && song_lost != nullptr)
    out.push_back(at_most("GPS lost at 370 s: joint-ca, position / song2015, late",
                          position_ratio(joint_lost->score, song_lost->score, late), 0.22));

  if (schmidt != nullptr) out.push_back(at_most("GPS-phase ripple, boost: schmidt", ripple(schmidt->score), 1.05));
  if (song != nullptr) out.push_back(at_least("GPS-phase ripple, boost: song2015", ripple(song->score), 1.3));

  const Flown* const wrong = result.find("joint-ca", Case::WrongBlocks);
  bias_left_rows(out, wrong, result.bound, "wrong bias blocks: bias left / polar bound", 2.0);
  position_rows(out, wrong, &result.bound_default_blocks, "wrong bias blocks: position / bound", {1.08, 1.08, 1.08});
  bias_left_rows(out, result.find("joint-ca", Case::TimeTag), result.bound_time_tag, "5 ms time tag: bias left / bound",
                 1.18);
  return out;
}

}  // namespace downrange::experiment::launch
