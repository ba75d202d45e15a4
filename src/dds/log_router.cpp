#include "dds/log_router.hpp"

#include <cstdio>
#include <fastdds/dds/log/Log.hpp>
#include <memory>
#include <utility>

namespace downrange::dds {
namespace {

using eprosima::fastdds::dds::Log;
using eprosima::fastdds::dds::LogConsumer;

void print(const LogLine& line) {
  std::fprintf(stderr, "dds %s [%s] %s\n", line.error ? "error" : "warning", line.category.c_str(), line.text.c_str());
}

/// State behind the middleware's one logging thread.
struct Router {
  std::mutex capture_mutex;  ///< held by the one LogCapture
  std::mutex mutex;
  std::function<void(const LogLine&)> sink = print;
  bool capturing = false;
  std::vector<LogLine> captured;

  Router();
};

class Consumer final : public LogConsumer {
 public:
  explicit Consumer(Router& router) : router_(router) {}

  void Consume(const Log::Entry& entry) override {
    const LogLine line{entry.kind == Log::Kind::Error, entry.context.category, entry.message};
    const std::scoped_lock lock(router_.mutex);
    if (router_.capturing) router_.captured.push_back(line);
    router_.sink(line);
  }

 private:
  Router& router_;
};

Router::Router() {
  Log::ClearConsumers();
  Log::RegisterConsumer(std::make_unique<Consumer>(*this));
}

/// Never destroyed: the middleware may log while the process exits.
Router& router() {
  static Router& instance = *new Router;
  return instance;
}

}  // namespace

void set_log_sink(std::function<void(const LogLine&)> sink) {
  const std::scoped_lock lock(router().mutex);
  router().sink = sink ? std::move(sink) : print;
}

LogCapture::LogCapture() : only_one_(router().capture_mutex) {
  Log::Flush();
  Log::SetVerbosity(Log::Kind::Warning);
  const std::scoped_lock lock(router().mutex);
  router().captured.clear();
  router().capturing = true;
}

LogCapture::~LogCapture() {
  Log::SetVerbosity(Log::Kind::Error);
  const std::scoped_lock lock(router().mutex);
  router().capturing = false;
}

std::vector<std::string> LogCapture::lines(std::string_view category, bool warnings) const {
  Log::Flush();
  const std::scoped_lock lock(router().mutex);
  std::vector<std::string> result;
  for (const LogLine& line : router().captured) {
    if ((line.error || warnings) && line.category.starts_with(category)) result.push_back(line.text);
  }
  return result;
}

}  // namespace downrange::dds
