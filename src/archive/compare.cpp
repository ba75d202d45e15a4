#include <algorithm>
#include <archive/channels.hpp>
#include <archive/compare.hpp>
#include <archive/reader.hpp>
#include <deque>
#include <set>

namespace downrange::archive {
namespace {

struct Message {
  std::uint64_t log_time;
  std::uint64_t publish_time;
  Bytes payload;
};

std::optional<std::string> difference(const Message& a, const Message& b) {
  if (a.log_time != b.log_time) return "log time: " + std::to_string(a.log_time) + " and " + std::to_string(b.log_time);
  if (a.publish_time != b.publish_time) {
    return "publish time: " + std::to_string(a.publish_time) + " and " + std::to_string(b.publish_time);
  }
  if (a.payload == b.payload) return std::nullopt;
  const auto [at_a, at_b] = std::mismatch(a.payload.begin(), a.payload.end(), b.payload.begin(), b.payload.end());
  return "payloads of " + std::to_string(a.payload.size()) + " and " + std::to_string(b.payload.size()) +
         " bytes, from byte " + std::to_string(at_a - a.payload.begin()) + " on";
}

/// One topic: messages that one archive is ahead of the other wait until theirs comes.
class Matcher {
 public:
  explicit Matcher(std::string topic) { result_.topic = std::move(topic); }

  void add(bool from_a, const RawMessage& raw) {
    ++(from_a ? result_.count_a : result_.count_b);
    if (result_.first) return;
    Message message{raw.log_time, raw.publish_time, {raw.payload.begin(), raw.payload.end()}};
    std::deque<Message>& others = from_a ? waiting_b_ : waiting_a_;
    if (others.empty()) {
      (from_a ? waiting_a_ : waiting_b_).push_back(std::move(message));
      return;
    }
    const Message other = std::move(others.front());
    others.pop_front();
    if (const auto what = from_a ? difference(message, other) : difference(other, message)) {
      result_.first = Difference{matched_, message.log_time, *what};
      waiting_a_.clear();
      waiting_b_.clear();
    }
    ++matched_;
  }

  TopicComparison finish() {
    const auto& rest = waiting_a_.empty() ? waiting_b_ : waiting_a_;
    if (!result_.first && !rest.empty()) {
      result_.first = Difference{matched_, rest.front().log_time,
                                 std::to_string(result_.count_a) + " messages and " + std::to_string(result_.count_b)};
    }
    return result_;
  }

 private:
  TopicComparison result_;
  std::deque<Message> waiting_a_;
  std::deque<Message> waiting_b_;
  std::uint64_t matched_ = 0;
};

std::set<std::string> result_topics() {
  std::set<std::string> topics;
  for (const Channel& channel : channels()) {
    if (channel.role == Role::Output) topics.emplace(channel.topic);
  }
  return topics;
}

}  // namespace

bool CompareReport::identical() const {
  const bool same = std::none_of(topics.begin(), topics.end(), [](const auto& t) { return t.first.has_value(); });
  return same && std::any_of(topics.begin(), topics.end(), [](const auto& t) { return t.count_a > 0; });
}

CompareReport compare(const std::filesystem::path& a, const std::filesystem::path& b,
                      const std::vector<std::string>& topics) {
  const std::set<std::string> wanted =
      topics.empty() ? result_topics() : std::set<std::string>(topics.begin(), topics.end());
  std::map<std::string, Matcher> matchers;
  for (const std::string& topic : wanted) matchers.emplace(topic, Matcher(topic));

  RawReader reader_a(a);
  RawReader reader_b(b);
  const auto advance = [&](RawReader& reader, bool from_a) {
    const auto message = reader.next();
    if (!message) return false;
    if (const auto found = matchers.find(message->channel->topic); found != matchers.end()) {
      found->second.add(from_a, *message);
    }
    return true;
  };
  bool more_a = true;
  bool more_b = true;
  while (more_a || more_b) {
    more_a = more_a && advance(reader_a, true);
    more_b = more_b && advance(reader_b, false);
  }
  for (const auto& [path, reader] : {std::pair{&a, &reader_a}, std::pair{&b, &reader_b}}) {
    reader->require_declared();
    if (const auto& cut = reader->truncated()) {
      throw ArchiveError(path->string() + ": cut off at byte " + std::to_string(cut->offset) + ": " + cut->what);
    }
  }

  CompareReport report;
  for (auto& [topic, matcher] : matchers) report.topics.push_back(matcher.finish());
  return report;
}

}  // namespace downrange::archive
