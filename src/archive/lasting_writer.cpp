#include <archive/lasting_writer.hpp>
#include <system_error>
#include <utility>

namespace downrange::archive {
namespace {

std::filesystem::path numbered(const std::filesystem::path& path, int n) {
  std::filesystem::path result = path;
  result.replace_filename(path.stem().string() + '-' + std::to_string(n) + path.extension().string());
  return result;
}

std::filesystem::path unused_number(const std::filesystem::path& path) {
  std::error_code unreadable;  // then the file cannot be made either, and the writer says why
  int n = 2;
  while (std::filesystem::exists(numbered(path, n), unreadable)) ++n;
  return numbered(path, n);
}

}  // namespace

std::filesystem::path unused_path(const std::filesystem::path& wanted) {
  std::error_code unreadable;
  return std::filesystem::exists(wanted, unreadable) ? unused_number(wanted) : wanted;
}

LastingWriter::LastingWriter(std::filesystem::path path, const WriterOptions& options, Beginning beginning)
    : first_path_(std::move(path)), options_(options), beginning_(std::move(beginning)) {
  begin(first_path_, {});
}

std::optional<std::string> LastingWriter::look() {
  writer_->flush();
  if (writer_->in_place()) return std::nullopt;
  const std::filesystem::path gone = path_;
  std::string text = gone.string() + " was removed or replaced while it was written: ";
  try {
    std::error_code ignored;  // the writer says why its file cannot be created
    std::filesystem::create_directories(first_path_.parent_path(), ignored);
    begin(unused_number(first_path_), gone);
    text += "recording goes on in " + path_.string();
  } catch (const ArchiveError& error) {
    text += error.what();
  }
  if (text == told_) return std::nullopt;
  told_ = text;
  return text;
}

std::vector<WrittenFile> LastingWriter::close() {
  leave();
  for (WrittenFile& file : left_) file.kept = file.kept && file.id.is_at(file.path);
  return std::move(left_);
}

void LastingWriter::leave() {
  const auto now_at = writer_->whereabouts();
  left_.push_back(
      {.path = now_at.value_or(path_), .id = writer_->id(), .status = writer_->close(), .kept = now_at.has_value()});
}

void LastingWriter::begin(const std::filesystem::path& path, const std::filesystem::path& continues) {
  auto writer = std::make_unique<Writer>(path, options_);
  beginning_(*writer, continues);
  writer->flush();
  if (writer_) leave();
  writer_ = std::move(writer);
  path_ = path;
}

}  // namespace downrange::archive
