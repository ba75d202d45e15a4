#include <archive/new_archive.hpp>
#include <system_error>

namespace downrange::archive {
namespace {

/// Where `path` is written; empty: directly.
std::filesystem::path part_of(const std::filesystem::path& path) {
  std::error_code error;
  const auto status = std::filesystem::status(path, error);
  if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status)) return {};
  // A link stays a link: its target is what is replaced.
  std::filesystem::path part = std::filesystem::exists(status) ? std::filesystem::canonical(path, error) : path;
  if (error) part = path;
  return part += ".part";
}

bool is_taken(const std::filesystem::path& path) {
  std::error_code error;
  return std::filesystem::exists(path, error);
}

}  // namespace

NewArchive::NewArchive(std::filesystem::path path, const WriterOptions& options)
    : path_(std::move(path)), part_(part_of(path_)), overwrite_(options.overwrite) {
  if (part_.empty()) {
    writer_.emplace(path_, options);
    return;
  }
  if (!overwrite_ && is_taken(path_)) throw ArchiveError(path_.string() + ": exists already");
  WriterOptions beside = options;
  beside.overwrite = true;  // left by a command that was killed
  writer_.emplace(part_, beside);
}

NewArchive::~NewArchive() {
  writer_.reset();
  remove_part();
}

WriterStatus NewArchive::close() {
  WriterStatus status = writer_->close();
  if (part_.empty()) return status;
  if (status.ok()) {
    std::error_code error;
    if (!overwrite_ && is_taken(path_)) error = std::make_error_code(std::errc::file_exists);
    std::filesystem::path named = part_;
    named.replace_extension();  // without ".part"
    if (!error) std::filesystem::rename(part_, named, error);
    if (error) status.failure = path_.string() + ": cannot be named so: " + error.message();
  }
  if (status.ok()) {
    part_.clear();
  } else {
    if (status.failure.empty()) status.failure = path_.string() + ": not all of it could be written";
    status.failure += "; nothing of it is kept";
    remove_part();
  }
  return status;
}

void NewArchive::remove_part() {
  std::error_code error;
  if (!part_.empty()) std::filesystem::remove(part_, error);
  part_.clear();
}

}  // namespace downrange::archive
