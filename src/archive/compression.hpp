#pragma once
/// Compression of MCAP chunks: "zstd", "lz4" (frame format) or none.

#include <archive/bytes.hpp>
#include <optional>
#include <string>
#include <string_view>

namespace downrange::archive {

enum class Compression : std::uint8_t { None, Zstd, Lz4 };

/// The name in a Chunk record: "", "zstd", "lz4".
[[nodiscard]] std::string_view to_string(Compression compression);
[[nodiscard]] std::optional<Compression> compression_named(std::string_view name);

/// Compresses chunk after chunk with one working memory. One thread at a time.
class Compressor {
 public:
  explicit Compressor(Compression compression);
  ~Compressor();
  Compressor(const Compressor&) = delete;
  Compressor& operator=(const Compressor&) = delete;

  /// Appends the compressed `in` to `out`. Throws std::runtime_error when the library refuses (out of memory).
  void compress(ByteView in, Bytes& out);

 private:
  Compression compression_;
  void* zstd_ = nullptr;
};

/// Fills `out` exactly from `in`. Returns what is wrong: damaged data, or a size other than out's; nothing when right.
[[nodiscard]] std::optional<std::string> decompress(Compression compression, ByteView in, std::span<std::uint8_t> out);

}  // namespace downrange::archive
