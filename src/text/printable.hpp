#pragma once
/// Text that a file or a peer states, made safe to print.

#include <string>
#include <string_view>

namespace downrange::text {

/// `text` with every byte that a terminal or a log could obey written out as \xNN: control characters (ESC, CR, BEL,
/// the C1 set in UTF-8 too) and bytes that are no UTF-8. Line breaks and tabs stay where `lines` is true, for messages
/// of several lines. Longer than `max_size` bytes: cut there, with "..." for the rest.
[[nodiscard]] std::string printable(std::string_view text, bool lines = false, std::size_t max_size = 100'000);

/// A name or a value in a message: printable, in single quotes, cut at 40 bytes.
[[nodiscard]] std::string in_quotes(std::string_view text);

}  // namespace downrange::text
