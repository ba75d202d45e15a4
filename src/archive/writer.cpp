#include <archive/record_catalogue.hpp>
#include <archive/writer.hpp>
#include <vector>

namespace downrange::archive {
namespace {

/// MCAP has no times before 1970; the record itself keeps them.
std::uint64_t timestamp(Time t) { return t.ns > 0 ? static_cast<std::uint64_t>(t.ns) : 0; }

struct Stamp {
  Time log;
  Time publish;
};

/// log_time = received, publish_time = epoch; of records that have not both, the one time they have.
template <class T>
Stamp stamp(const T& record) {
  if constexpr (std::is_same_v<T, SlavingCommand>) {
    return {record.tick, record.apply_at};
  } else if constexpr (requires { record.received; }) {
    return {record.received, record.epoch};
  } else if constexpr (requires { record.epoch; }) {
    return {record.epoch, record.epoch};
  } else if constexpr (requires { record.time; }) {
    return {record.time, record.time};
  } else {
    return {record.tick, record.tick};
  }
}

}  // namespace

class Writer::Impl {
 public:
  Impl(const std::filesystem::path& path, const WriterOptions& options)
      : options_(options), file_(path, {options.compression, options.queue_chunks, options.overwrite}) {
    chunk_.reserve(options_.chunk_size);
  }

  ~Impl() { finish(); }

  template <class T>
  void write_input(const T& event) {
    ++sequence_;
    append(Role::Input, event);
  }

  template <class T>
  void append(Role role, const T& record) {
    if (closed_ || file_.failed()) {
      file_.count_lost(1);
      return;
    }
    const Stamp times = stamp(record);
    const std::uint64_t log_time = timestamp(times.log);
    const bool due = log_time >= chunk_start_ + static_cast<std::uint64_t>(options_.chunk_time.ns);
    if (chunk_messages_ > 0 && (due || chunk_.size() >= options_.chunk_size)) flush();
    if (chunk_messages_ == 0) chunk_start_ = log_time;
    const Channel& channel = channel_of<T>(role);
    announce(channel);

    auto& message = std::get<Proto<T>>(messages_);
    to_proto(record, message);
    const std::size_t size = message.ByteSizeLong();
    put_record_header(chunk_, Op::Message, message_header_size + size);
    put(chunk_, channel.id);
    put(chunk_, sequence_);
    put(chunk_, log_time);
    put(chunk_, timestamp(times.publish));
    const std::size_t at = chunk_.size();
    chunk_.resize(at + size);
    message.SerializeWithCachedSizesToArray(chunk_.data() + at);
    ++chunk_messages_;
  }

  void put_block(Op op, Bytes record) {
    if (!closed_) file_.submit({op, std::move(record), 0}, true);
  }

  void flush() {
    if (chunk_messages_ == 0) return;
    const bool kept = file_.submit({Op::Chunk, std::move(chunk_), chunk_messages_}, options_.backlog == Backlog::Wait);
    if (!kept) announced_.assign(announced_.size(), false);  // its schemas and channels may be gone with it
    chunk_ = file_.spare_buffer();
    chunk_.reserve(options_.chunk_size);
    chunk_messages_ = 0;
  }

  void finish() {
    if (closed_) return;
    flush();
    closed_ = true;
    file_.finish();
  }

  [[nodiscard]] const FileThread& file() const { return file_; }

 private:
  /// A channel, and its schema, must stand in the file before its first message.
  void announce(const Channel& channel) {
    if (announced_[channel.id]) return;
    announced_[channel.id] = true;
    put_record(chunk_, Op::Schema, schema_record(channel));
    put_record(chunk_, Op::Channel, channel_record(channel));
  }

  WriterOptions options_;
  FileThread file_;
  Records::Tuple<Proto> messages_;  ///< used again and again: in steady state encoding allocates nothing
  Bytes chunk_;
  std::uint64_t chunk_messages_ = 0;
  std::uint64_t chunk_start_ = 0;  ///< log time of its first message
  std::uint32_t sequence_ = 0;
  std::vector<bool> announced_ = std::vector<bool>(channels().size() + 1);  ///< by channel id
  bool closed_ = false;
};

Writer::Writer(const std::filesystem::path& path, const WriterOptions& options)
    : impl_(std::make_unique<Impl>(path, options)) {}
Writer::~Writer() = default;

void Writer::write(const Event& event) {
  std::visit([this](const auto& e) { impl_->write_input(e); }, event);
}

void Writer::write(const Result& result) {
  std::visit([this](const auto& r) { impl_->append(Role::Output, r); }, result);
}

void Writer::write_last_tick(Time tick) { impl_->append(Role::Mark, LastTick{tick}); }

void Writer::write_truth(const Truth& truth) { impl_->append(Role::Truth, truth); }

void Writer::attach(std::string_view name, std::string_view media_type, std::string_view data, Time log_time) {
  Bytes content;
  put(content, timestamp(log_time));
  put(content, std::uint64_t{0});  // create_time: not known
  put_string(content, name);
  put_string(content, media_type);
  put(content, static_cast<std::uint64_t>(data.size()));
  content.insert(content.end(), data.begin(), data.end());
  put(content, crc32(content));
  Bytes record;
  put_record(record, Op::Attachment, content);
  impl_->put_block(Op::Attachment, std::move(record));
}

void Writer::metadata(std::string_view name, const std::map<std::string, std::string>& values) {
  Bytes map;
  for (const auto& [key, value] : values) {
    put_string(map, key);
    put_string(map, value);
  }
  Bytes content;
  put_string(content, name);
  put(content, static_cast<std::uint32_t>(map.size()));
  put_bytes(content, map);
  Bytes record;
  put_record(record, Op::Metadata, content);
  impl_->put_block(Op::Metadata, std::move(record));
}

void Writer::flush() { impl_->flush(); }

WriterStatus Writer::close() {
  impl_->finish();
  return impl_->file().status();
}

bool Writer::failed() const { return impl_->file().failed(); }

bool Writer::in_place() const { return impl_->file().in_place(); }

std::optional<std::filesystem::path> Writer::whereabouts() const { return impl_->file().whereabouts(); }

const FileId& Writer::id() const { return impl_->file().id(); }

WriterStatus Writer::status() const { return impl_->file().status(); }

}  // namespace downrange::archive
