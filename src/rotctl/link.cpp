#include "rotctl/link.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <numbers>
#include <utility>

#include "text/printable.hpp"

namespace downrange::rotctl {
namespace {

/// Protocol 0 does not say where its state ends: when nothing more has come for so long.
constexpr Duration state_tail = milliseconds(250);

std::string refusal(const std::string& what, int code) {
  return "the rotator refuses " + what + ": RPRT " + std::to_string(code) + ", " + std::string(meaning_of(code));
}

}  // namespace

Link::Link(const LinkSettings& settings) : settings_(settings), period_(seconds(1 / settings.rate_hz)) {}

void Link::connected(const CommandBook& book, Instant now) {
  lines_ = {};
  asked_.clear();
  state_ = {};
  state_enough_ = established_ = pointing_due_ = false;
  first_line_.reset();
  fault_.clear();
  output_.clear();
  for (std::string& said : said_) said.clear();
  next_cycle_ = now.up;
  next_stop_ = now.up;
  if (stop_due(book, now)) ask_stop(now);
  ask({Question::State, now, {}, 0}, "\\dump_state\n");
}

void Link::disconnected() {
  asked_.clear();
  output_.clear();
  established_ = false;
  follows_ = false;
}

void Link::ask(const Asked& what, const std::string& line) {
  if (asked_.empty()) waiting_since_ = what.at.up;
  asked_.push_back(what);
  output_ += line;
}

void Link::ask_stop(Instant now) {
  ask({Question::Stop, now, {}, 0}, "S\n");
  next_stop_ = now.up + period_;
  follows_ = false;
  ++counts_.stops;
}

bool Link::stopping() const {
  return std::ranges::any_of(asked_, [](const Asked& a) { return a.question == Question::Stop; });
}

bool Link::stop_due(const CommandBook& book, Instant now) const {
  if (!moving_ || stopping() || now.up < next_stop_) return false;
  const std::optional<Time> until = book.valid_until();
  return !until || now.utc + settings_.link_delay >= *until;
}

void Link::stop(Instant now) {
  ending_ = true;
  if (moving_ && !stopping()) ask_stop(now);
}

void Link::step(const CommandBook& book, Instant now) {
  if (!fault_.empty()) return;
  if (book.expired() > 0)
    note(LateTopic, "commands have expired when they come: the clocks differ, or the way is too long");
  if (book.from_future() > 0)
    note(FutureTopic, "commands apply too far ahead, and are not followed: the clocks differ");
  if (stop_due(book, now)) ask_stop(now);
  if (state_enough_ && now.up - waiting_since_ >= state_tail) {
    answered(now);
    establish(now);
  }
  if (!asked_.empty()) {
    if (now.up - waiting_since_ >= settings_.timeout) fail_late();
    return;
  }
  if (pointing_due_) return ask_pointing(now);
  if (now.up < next_cycle_) return;
  next_cycle_ = next_cycle_ + period_;
  if (next_cycle_ <= now.up) next_cycle_ = now.up + period_;
  const std::optional<CommandedPointing> aim = book.at(now.utc + settings_.link_delay + settings_.lead);
  if (!aim) return ask_pointing(now);
  ask_position(*aim, now);
  pointing_due_ = true;
}

void Link::ask_pointing(Instant now) {
  pointing_due_ = false;
  ask({Question::Pointing, now, {}, 0}, "p\n");
}

void Link::ask_position(const CommandedPointing& aim, Instant now) {
  const Placed placed = turns_->place(aim.azimuth_rad, aim.elevation_rad, measured_azimuth_rad_);
  note(HeldTopic, placed.held ? "the rotator does not reach what is commanded: held at the end of its travel" : "");
  ask({Question::Position, now, aim.tick, placed.turn_rad}, position_line(placed.azimuth_rad, placed.elevation_rad));
  moving_ = true;
  next_stop_ = now.up;
  ++counts_.positions;
}

Duration Link::due(const CommandBook& book, Instant now) const {
  Duration due = next_cycle_;
  if (!asked_.empty())
    due = waiting_since_ + (state_enough_ ? state_tail : settings_.timeout);
  else if (pointing_due_)
    due = now.up;
  if (moving_ && !stopping()) {
    const Time stop = book.valid_until().value_or(now.utc) - settings_.link_delay;
    due = std::min(due, std::max(next_stop_, now.up + (stop - now.utc)));
  }
  return due;
}

void Link::receive(std::string_view bytes, Instant now) {
  lines_.add(bytes);
  while (fault_.empty()) {
    const std::optional<std::string> line = lines_.next();
    if (lines_.endless()) return fail("a line without end: this is no rotctld");
    if (!line) return;
    answer(*line, now);
  }
}

void Link::answer(const std::string& line, Instant now) {
  if (asked_.empty()) return fail("an answer that nobody asked for", line);
  const Question question = asked_.front().question;
  if (question == Question::State) return answer_state(line, now);
  if (question == Question::Pointing) return answer_pointing(line, now);
  const std::optional<int> code = parse_report(line);
  if (!code) return fail(question == Question::Stop ? "no answer to S" : "no answer to P", line);
  question == Question::Stop ? answer_stop(*code) : answer_position(*code);
  answered(now);
}

void Link::answered(Instant now) {
  asked_.pop_front();
  waiting_since_ = now.up;
}

void Link::answer_state(const std::string& line, Instant now) {
  const std::optional<int> code = parse_report(line);
  if (code && *code != rprt_ok) {  // a daemon that does not know the question
    state_ = {};
  } else {
    const StateReply::Progress progress = state_.add(line);
    if (progress == StateReply::Progress::Wrong) return fail("no answer to \\dump_state", line);
    waiting_since_ = now.up;
    state_enough_ = progress == StateReply::Progress::Enough;
    if (progress != StateReply::Progress::Done) return;
  }
  answered(now);
  establish(now);
}

void Link::establish(Instant now) {
  established_ = true;
  state_enough_ = false;
  next_cycle_ = now.up;
  const std::optional<Travel> own = state_.travel();
  const Travel travel = own.value_or(settings_.travel);
  turns_.emplace(travel);
  std::string text = "connected, ";
  text += own ? "rotator model " + std::to_string(state_.model()) + ": " + to_string(travel)
              : "the rotator does not tell its travel: that of the configuration counts, " + to_string(travel);
  const Travel& commanded = settings_.travel;
  constexpr double rounding = 1e-6;
  if (commanded.azimuth_min_rad < travel.azimuth_min_rad - rounding ||
      commanded.azimuth_max_rad > travel.azimuth_max_rad + rounding ||
      commanded.elevation_min_rad < travel.elevation_min_rad - rounding ||
      commanded.elevation_max_rad > travel.elevation_max_rad + rounding)
    text += "; the configuration has more (" + to_string(commanded) +
            "): go-arounds are not planned where they will be needed, set azimuth_min_deg and so on of [[antenna]]";
  note(StateTopic, text);
}

void Link::answer_position(int code) {
  follows_ = code == rprt_ok && !stopping();
  if (code != rprt_ok) {
    ++counts_.refused;
    return note(MotionTopic, refusal("a position", code));
  }
  followed_tick_ = asked_.front().tick;
  followed_turn_rad_ = asked_.front().turn_rad;
  note(MotionTopic, "follows its commands");
}

void Link::answer_stop(int code) {
  if (code != rprt_ok) {
    ++counts_.refused;
    return note(MotionTopic, refusal("to stop", code) + "; tried again");
  }
  moving_ = false;
  note(MotionTopic, ending_ ? "stopped" : "stopped: there is no command to follow");
}

void Link::answer_pointing(const std::string& line, Instant now) {
  if (const std::optional<int> code = parse_report(line); code && !first_line_) {
    note(PointingTopic, "the rotator does not tell where it points: RPRT " + std::to_string(*code) + ", " +
                            std::string(meaning_of(*code)));
    return answered(now);
  }
  const std::optional<double> degrees = parse_degrees(line);
  if (!degrees) return fail("no answer to p", line);
  if (!first_line_) {
    first_line_ = degrees;
    return;
  }
  constexpr double deg = std::numbers::pi / 180;
  // The rotator read its encoders after it was asked and before it answered.
  const Time asked = asked_.front().at.utc;
  const Time epoch = asked + Duration{(now.up - asked_.front().at.up).ns / 2};
  report(*std::exchange(first_line_, std::nullopt) * deg, *degrees * deg, epoch);
  note(PointingTopic, "");
  answered(now);
}

void Link::report(double azimuth_rad, double elevation_rad, Time epoch) {
  measured_azimuth_rad_ = azimuth_rad;
  AntennaReport report;
  report.antenna = settings_.antenna;
  report.sequence = ++sequence_;
  report.epoch = epoch;
  report.azimuth_rad = follows_ ? azimuth_rad - followed_turn_rad_ : azimuth_rad;
  report.elevation_rad = elevation_rad;
  report.mode = follows_ ? AntennaMode::Slaved : AntennaMode::Manual;
  if (follows_) report.command_tick = followed_tick_;
  report.simulated = settings_.simulated;
  reports_.push_back(report);
  ++counts_.reports;
}

void Link::fail(const std::string& why, std::string_view line) {
  fault_ = line.empty() ? why : why + ": found " + text::in_quotes(line);
}

void Link::fail_late() {
  constexpr std::array<const char*, 4> questions{"\\dump_state", "P", "p", "S"};
  std::array<char, 80> text{};
  std::snprintf(text.data(), text.size(), "no answer to %s within %g s",
                questions.at(static_cast<std::size_t>(asked_.front().question)), settings_.timeout.seconds());
  fail(text.data());
}

void Link::note(Topic topic, const std::string& text) {
  if (said_[topic] == text) return;
  said_[topic] = text;
  if (!text.empty()) notes_.push_back(text);
}

std::string Link::take_output() { return std::exchange(output_, {}); }
std::vector<AntennaReport> Link::take_reports() { return std::exchange(reports_, {}); }
std::vector<std::string> Link::take_notes() { return std::exchange(notes_, {}); }

}  // namespace downrange::rotctl
