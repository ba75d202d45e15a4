#pragma once
/// Parts of which the schema is made: a Key reads, bounds, converts and shows one value of a struct S. A number's unit
/// is the suffix of its key, so that name and conversion cannot disagree.

#include <downrange/geo/name.hpp>
#include <downrange/geo/site.hpp>
#include <downrange/geo/time.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <type_traits>
#include <utility>
#include <vector>

namespace toml {
inline namespace v3 {
class node;
}
}  // namespace toml

namespace downrange::config {

/// Closed interval of allowed values, in the key's unit.
struct Limits {
  double min;
  double max;
};

enum class Need { Required, Optional };
inline constexpr Need required = Need::Required;
inline constexpr Need optional = Need::Optional;

struct KeyInfo {
  std::string name;
  std::string allowed;  ///< "a number from 0 to 90 deg"
  Need need;
  std::string help;
  bool text = false;  ///< the value is one text: an override may leave out the quotes
};

/// A value of S, read and written by copy.
template <class S, class T>
struct Field {
  std::function<T(const S&)> get;
  std::function<void(S&, T)> set;
};

/// s.*outer, or of that the member `inner`, and so on.
template <class S, class M, class... Inner>
auto& member_of(S& s, M outer, Inner... inner) {
  if constexpr (sizeof...(inner) == 0) {
    return s.*outer;
  } else {
    return member_of(s.*outer, inner...);
  }
}
template <class S, class M, class... Inner>
auto at(M S::*outer, Inner... inner) {
  using T = std::remove_reference_t<decltype(member_of(std::declval<S&>(), outer, inner...))>;
  return Field<S, T>{[=](const S& s) { return member_of(s, outer, inner...); },
                     [=](S& s, T value) { member_of(s, outer, inner...) = std::move(value); }};
}
/// One geodetic coordinate of a site.
template <class S>
Field<S, double> at(Site S::*site, double Geodetic::*coordinate) {
  return {[=](const S& s) { return (s.*site).geodetic().*coordinate; },
          [=](S& s, double value) {
            Geodetic g = (s.*site).geodetic();
            g.*coordinate = value;
            s.*site = Site(g);
          }};
}

template <class S>
struct Key {
  KeyInfo info;
  /// Stores the node's value; false when it is not an allowed one.
  std::function<bool(S&, const toml::node&)> read;
  std::function<std::string(const S&)> show;  ///< as the file would say it
};

/// Unit of a key by its suffix: its name for people and the factor into SI and radians.
struct Unit {
  std::string_view suffix;
  std::string_view name;
  double to_si;
};
[[nodiscard]] Unit unit_of(std::string_view key);

// Readers of one node: nothing when the type or the value is not allowed.
[[nodiscard]] std::optional<double> read_number(const toml::node& node, Limits limits);
[[nodiscard]] std::optional<int> read_integer(const toml::node& node, Limits limits);
[[nodiscard]] std::optional<bool> read_flag(const toml::node& node);
[[nodiscard]] std::optional<std::string> read_text(const toml::node& node);
[[nodiscard]] std::optional<Name> read_id(const toml::node& node);
[[nodiscard]] std::optional<std::vector<std::string>> read_texts(const toml::node& node);
[[nodiscard]] std::optional<std::vector<Name>> read_ids(const toml::node& node);

[[nodiscard]] bool is_id(std::string_view text);
[[nodiscard]] std::string allowed_number(std::string_view key, Limits limits);
[[nodiscard]] std::string allowed_integer(Limits limits);
[[nodiscard]] std::string allowed_choice(const std::vector<std::string_view>& choices);
[[nodiscard]] std::string show_number(double value);
/// As a TOML string, whatever is in it.
[[nodiscard]] std::string show_text(std::string_view text);
[[nodiscard]] std::string show_texts(const std::vector<std::string>& texts);
[[nodiscard]] std::string show_ids(const std::vector<Name>& ids);
/// A node as an error message quotes it.
[[nodiscard]] std::string show_found(const toml::node& node);
inline constexpr std::string_view allowed_id = "text of 1 to 31 characters out of A-Z a-z 0-9 . _ -";

/// A physical quantity; the suffix of `name` says its unit.
template <class S>
Key<S> number(std::string name, Field<S, double> field, Limits limits, Need need, std::string help) {
  const double to_si = unit_of(name).to_si;
  return {{name, allowed_number(name, limits), need, std::move(help)},
          [=](S& s, const toml::node& node) {
            const auto value = read_number(node, limits);
            if (value) field.set(s, *value * to_si);
            return value.has_value();
          },
          [=](const S& s) { return show_number(field.get(s) / to_si); }};
}

/// A span of time, to the nearest nanosecond.
template <class S>
Key<S> span(std::string name, Field<S, Duration> field, Limits limits, Need need, std::string help) {
  const double to_si = unit_of(name).to_si;
  return {{name, allowed_number(name, limits), need, std::move(help)},
          [=](S& s, const toml::node& node) {
            const auto value = read_number(node, limits);
            if (value) field.set(s, seconds(*value * to_si));
            return value.has_value();
          },
          [=](const S& s) { return show_number(field.get(s).seconds() / to_si); }};
}

template <class S>
Key<S> integer(std::string name, Field<S, int> field, Limits limits, Need need, std::string help) {
  return {{std::move(name), allowed_integer(limits), need, std::move(help)},
          [=](S& s, const toml::node& node) {
            const auto value = read_integer(node, limits);
            if (value) field.set(s, *value);
            return value.has_value();
          },
          [=](const S& s) { return std::to_string(field.get(s)); }};
}

template <class S>
Key<S> flag(std::string name, Field<S, bool> field, Need need, std::string help) {
  return {{std::move(name), "true or false", need, std::move(help)},
          [=](S& s, const toml::node& node) {
            const auto value = read_flag(node);
            if (value) field.set(s, *value);
            return value.has_value();
          },
          [=](const S& s) { return field.get(s) ? "true" : "false"; }};
}

/// An identifier as it appears on topics and in file names.
template <class S>
Key<S> id(std::string name, Field<S, Name> field, Need need, std::string help) {
  return {{std::move(name), std::string(allowed_id), need, std::move(help), true},
          [=](S& s, const toml::node& node) {
            const auto value = read_id(node);
            if (value) field.set(s, *value);
            return value.has_value();
          },
          [=](const S& s) { return show_text(field.get(s).view()); }};
}

template <class S>
Key<S> ids(std::string name, Field<S, std::vector<Name>> field, Need need, std::string help) {
  return {
      {std::move(name), "a list of texts, each of 1 to 31 characters out of A-Z a-z 0-9 . _ -", need, std::move(help)},
      [=](S& s, const toml::node& node) {
        auto value = read_ids(node);
        if (value) field.set(s, std::move(*value));
        return value.has_value();
      },
      [=](const S& s) { return show_ids(field.get(s)); }};
}

/// A file or folder; made absolute against the configuration's own folder by load.
template <class S>
Key<S> path(std::string name, Field<S, std::filesystem::path> field, Need need, std::string help) {
  return {{std::move(name), "the path of a file or folder, as text", need, std::move(help), true},
          [=](S& s, const toml::node& node) {
            auto value = read_text(node);
            if (value) field.set(s, std::filesystem::path(std::move(*value)));
            return value.has_value();
          },
          [=](const S& s) { return show_text(field.get(s).string()); }};
}

template <class S, class E>
Key<S> choice(std::string name, Field<S, E> field, std::vector<std::pair<std::string_view, E>> choices, Need need,
              std::string help) {
  std::vector<std::string_view> names;
  names.reserve(choices.size());
  for (const auto& [text, value] : choices) names.push_back(text);
  return {{std::move(name), allowed_choice(names), need, std::move(help), true},
          [=](S& s, const toml::node& node) {
            const auto found = read_text(node);
            for (const auto& [text, value] : choices) {
              if (found == text) return field.set(s, value), true;
            }
            return false;
          },
          [=](const S& s) {
            for (const auto& [text, value] : choices) {
              if (value == field.get(s)) return show_text(text);
            }
            return std::string();
          }};
}

}  // namespace downrange::config
