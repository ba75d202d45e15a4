#include <lz4frame.h>
#include <zstd.h>

#include <algorithm>
#include <archive/compression.hpp>
#include <memory>
#include <new>
#include <stdexcept>

namespace downrange::archive {
namespace {

/// zstd's fastest regular level: the records shrink to about a third at some 400 MB/s.
constexpr int zstd_level = 1;

std::optional<std::string> decompress_zstd(ByteView in, std::span<std::uint8_t> out) {
  const std::size_t size = ZSTD_decompress(out.data(), out.size(), in.data(), in.size());
  if (ZSTD_isError(size)) return std::string("zstd: ") + ZSTD_getErrorName(size);
  if (size != out.size()) return "zstd: " + std::to_string(size) + " bytes instead of " + std::to_string(out.size());
  return std::nullopt;
}

std::optional<std::string> decompress_lz4(ByteView in, std::span<std::uint8_t> out) {
  LZ4F_dctx* context = nullptr;
  if (const auto error = LZ4F_createDecompressionContext(&context, LZ4F_VERSION); LZ4F_isError(error)) {
    return std::string("lz4: ") + LZ4F_getErrorName(error);
  }
  const std::unique_ptr<LZ4F_dctx, decltype(&LZ4F_freeDecompressionContext)> guard(context,
                                                                                   &LZ4F_freeDecompressionContext);
  // Frame after frame, also none and empty ones, as zstd has it.
  std::size_t produced = 0;
  std::size_t hint = 0;  // bytes still wanted; 0 between frames
  while (!in.empty() || hint != 0) {
    std::size_t room = out.size() - produced;
    std::size_t taken = in.size();
    hint = LZ4F_decompress(context, out.data() + produced, &room, in.data(), &taken, nullptr);
    if (LZ4F_isError(hint)) return std::string("lz4: ") + LZ4F_getErrorName(hint);
    if (room == 0 && taken == 0 && hint != 0) return "lz4: frame ends early or is longer than the chunk says";
    produced += room;
    in = in.subspan(taken);
  }
  if (produced != out.size()) {
    return "lz4: " + std::to_string(produced) + " bytes instead of " + std::to_string(out.size());
  }
  return std::nullopt;
}

}  // namespace

std::string_view to_string(Compression compression) {
  switch (compression) {
    case Compression::None:
      return "";
    case Compression::Zstd:
      return "zstd";
    case Compression::Lz4:
      return "lz4";
  }
  return "";
}

std::optional<Compression> compression_named(std::string_view name) {
  for (const Compression c : {Compression::None, Compression::Zstd, Compression::Lz4}) {
    if (name == to_string(c)) return c;
  }
  return std::nullopt;
}

Compressor::Compressor(Compression compression) : compression_(compression) {
  if (compression_ != Compression::Zstd) return;
  zstd_ = ZSTD_createCCtx();
  if (zstd_ == nullptr) throw std::bad_alloc();
}

Compressor::~Compressor() { ZSTD_freeCCtx(static_cast<ZSTD_CCtx*>(zstd_)); }

void Compressor::compress(ByteView in, Bytes& out) {
  const std::size_t at = out.size();
  std::size_t size = 0;
  switch (compression_) {
    case Compression::None:
      put_bytes(out, in);
      return;
    case Compression::Zstd:
      out.resize(at + ZSTD_compressBound(in.size()));
      size = ZSTD_compressCCtx(static_cast<ZSTD_CCtx*>(zstd_), out.data() + at, out.size() - at, in.data(), in.size(),
                               zstd_level);
      if (ZSTD_isError(size)) throw std::runtime_error(std::string("zstd: ") + ZSTD_getErrorName(size));
      break;
    case Compression::Lz4:
      out.resize(at + LZ4F_compressFrameBound(in.size(), nullptr));
      size = LZ4F_compressFrame(out.data() + at, out.size() - at, in.data(), in.size(), nullptr);
      if (LZ4F_isError(size)) throw std::runtime_error(std::string("lz4: ") + LZ4F_getErrorName(size));
      break;
  }
  out.resize(at + size);
}

std::optional<std::string> decompress(Compression compression, ByteView in, std::span<std::uint8_t> out) {
  switch (compression) {
    case Compression::None:
      if (in.size() != out.size()) return "stored size differs from what the chunk says";
      std::copy(in.begin(), in.end(), out.begin());
      return std::nullopt;
    case Compression::Zstd:
      return decompress_zstd(in, out);
    case Compression::Lz4:
      return decompress_lz4(in, out);
  }
  return "unknown compression";
}

}  // namespace downrange::archive
