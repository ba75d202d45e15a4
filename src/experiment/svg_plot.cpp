#include "experiment/svg_plot.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <sstream>

namespace downrange::experiment {
namespace {

constexpr double page_width = 760;
constexpr double height_alone = 380;
constexpr double height_in_row = 270;
constexpr double least_width = 300;  ///< three of them stand side by side on a wide screen
constexpr double left = 72;
constexpr double right = 16;
constexpr double top = 12;
constexpr double bottom = 48;
constexpr int colours = 8;
constexpr int dash_patterns = 4;

struct Tick {
  double at;
  std::string text;
};

struct Canvas {
  double width = page_width;
  double height = height_alone;
};

/// One axis: what the data span, mapped to pixels.
struct Axis {
  double low = 0;  ///< logarithms to base 10 on a logarithmic axis
  double high = 1;
  bool log = false;
  double pixel_low = 0;
  double pixel_high = 1;

  [[nodiscard]] bool shows(double value) const { return std::isfinite(value) && (!log || value > 0); }
  [[nodiscard]] double pixel(double value) const {
    const double u = log ? std::log10(value) : value;
    return pixel_low + (u - low) / (high - low) * (pixel_high - pixel_low);
  }
};

std::string text_of(double value, int decimals) {
  char buffer[40];
  const bool long_number = std::abs(value) >= 1e5 || (value != 0 && std::abs(value) < 1e-4);
  if (long_number)
    std::snprintf(buffer, sizeof buffer, "%.3g", value);
  else
    std::snprintf(buffer, sizeof buffer, "%.*f", decimals, value);
  return buffer;
}

/// Multiples of 1, 2 or 5 times a power of ten: five to ten of them on a plot of its own.
std::vector<Tick> linear_ticks(const Axis& axis) {
  const double wanted = std::clamp(std::abs(axis.pixel_high - axis.pixel_low) / 45, 3.0, 7.0);
  const double rough = (axis.high - axis.low) / wanted;
  const double power = std::pow(10, std::floor(std::log10(rough)));
  const double step = power * (rough / power < 1.5 ? 1 : rough / power < 3.5 ? 2 : rough / power < 7.5 ? 5 : 10);
  const int decimals = std::max(0, static_cast<int>(-std::floor(std::log10(step) + 1e-9)));
  std::vector<Tick> ticks;
  for (double k = std::ceil(axis.low / step - 1e-9); k * step <= axis.high + 1e-9 * step; ++k)
    ticks.push_back({k * step, text_of(k == 0 ? 0.0 : k * step, decimals)});
  return ticks;
}

/// Powers of ten; 2 and 5 times them as well where there are few, every other one where there are many. As on a linear
/// axis where not even a few of these are in view.
std::vector<Tick> log_ticks(const Axis& axis) {
  const double decades = axis.high - axis.low;
  if (decades < 0.8) {
    Axis linear = axis;
    linear.low = std::pow(10, axis.low);
    linear.high = std::pow(10, axis.high);
    return linear_ticks(linear);
  }
  const int every = decades > 8 ? static_cast<int>(std::ceil(decades / 8)) : 1;
  std::vector<double> multiples{1};
  if (decades < 3) multiples = {1, 2, 5};
  std::vector<Tick> ticks;
  for (int power = static_cast<int>(std::floor(axis.low)); power <= axis.high; power += every) {
    for (const double multiple : multiples) {
      const double value = multiple * std::pow(10, power);
      if (std::log10(value) < axis.low - 1e-9 || std::log10(value) > axis.high + 1e-9) continue;
      ticks.push_back({value, text_of(value, std::max(0, -power))});
    }
  }
  return ticks;
}

/// Of all values that can be shown, magnitudes up to `most`, with some air around them.
Axis axis_of(std::span<const Plot> row, std::vector<double> Curve::*values, bool log, double pixel_low,
             double pixel_high, double air, double most) {
  Axis axis{.low = std::numeric_limits<double>::infinity(),
            .high = -std::numeric_limits<double>::infinity(),
            .log = log,
            .pixel_low = pixel_low,
            .pixel_high = pixel_high};
  for (const Plot& plot : row) {
    for (const Curve& curve : plot.curves) {
      for (const double of_curve : curve.*values) {
        if (!axis.shows(of_curve)) continue;
        const double value = std::clamp(of_curve, -most, most);
        axis.low = std::min(axis.low, log ? std::log10(value) : value);
        axis.high = std::max(axis.high, log ? std::log10(value) : value);
      }
    }
  }
  if (!(axis.low <= axis.high)) axis.low = 0, axis.high = 1;
  if (axis.high - axis.low <= 1e-12 * std::max(1.0, std::abs(axis.high))) {
    const double half = log ? 0.5 : std::max(1e-12, 0.5 * std::abs(axis.high));
    axis.low -= half;
    axis.high += half;
  }
  const bool from_zero = !log && air > 0 && axis.low > 0 && axis.low < 0.4 * axis.high;
  const double span = axis.high - axis.low;
  axis.low = from_zero ? 0 : axis.low - air * span;
  axis.high += air * span;
  return axis;
}

struct Pixel {
  double x;
  double y;
};

/// Of each column of pixels the first, least, greatest and last point; only for lines whose x does not go back.
std::vector<Pixel> thinned(const std::vector<Pixel>& line) {
  const auto goes_back = [](const Pixel& a, const Pixel& b) { return b.x < a.x; };
  if (line.size() < 2 * static_cast<std::size_t>(page_width) ||
      std::adjacent_find(line.begin(), line.end(), goes_back) != line.end())
    return line;
  std::vector<Pixel> kept;
  for (auto first = line.begin(); first != line.end();) {
    const double column = std::floor(first->x);
    const auto last = std::find_if(first, line.end(), [column](const Pixel& p) { return std::floor(p.x) != column; });
    const auto lower = [](const Pixel& a, const Pixel& b) { return a.y < b.y; };
    const auto [least, greatest] = std::minmax_element(first, last, lower);
    kept.push_back(*first);
    kept.push_back(*std::min(least, greatest));
    kept.push_back(*std::max(least, greatest));
    kept.push_back(*std::prev(last));
    first = last;
  }
  return kept;
}

std::string path_data(const Curve& curve, const Axis& x, const Axis& y) {
  std::string data;
  char buffer[48];
  std::vector<Pixel> line;
  const auto end_line = [&] {
    const std::vector<Pixel> kept = curve.points ? line : thinned(line);
    for (std::size_t i = 0; i < kept.size(); ++i) {
      const bool dot = curve.points || kept.size() == 1;
      std::snprintf(buffer, sizeof buffer,
                    dot      ? "M%.1f %.1fh.01"
                    : i == 0 ? "M%.1f %.1f"
                             : "L%.1f %.1f",
                    kept[i].x, kept[i].y);
      data += buffer;
    }
    line.clear();
  };
  const std::size_t count = std::min(curve.x.size(), curve.y.size());
  for (std::size_t i = 0; i < count; ++i) {
    if (x.shows(curve.x[i]) && y.shows(curve.y[i]))
      line.push_back({x.pixel(curve.x[i]), std::clamp(y.pixel(curve.y[i]), y.pixel_high, y.pixel_low)});
    else
      end_line();
  }
  end_line();
  return data;
}

/// A sensor in a scenario, a nominal point: to be seen, not counted.
bool is_mark(const Curve& curve) { return curve.points && curve.x.size() <= 3; }

/// Solid curves take the next colour, dashed ones the ink and the next pattern of dashes.
std::vector<std::string> classes_of(const Plot& plot) {
  std::vector<std::string> classes;
  int colour = 0;
  int dash = 0;
  for (const Curve& curve : plot.curves) {
    if (curve.label.empty() && !classes.empty()) {
      classes.push_back(classes.back());
    } else if (curve.dashed) {
      classes.push_back("dash dash-" + std::to_string(dash++ % dash_patterns));
    } else {
      const char* const kind = is_mark(curve) ? "mark" : curve.points ? "dots" : "line";
      classes.push_back(std::string(kind) + " series-" + std::to_string(colour++ % colours));
    }
  }
  return classes;
}

void write_axes(std::ostream& out, const Plot& plot, const Canvas& canvas, const Axis& x, const Axis& y) {
  const auto [width, height] = canvas;
  const std::vector<Tick> x_ticks = linear_ticks(x);
  const std::vector<Tick> y_ticks = y.log ? log_ticks(y) : linear_ticks(y);
  out << "<g class=\"grid\">";
  for (const Tick& t : x_ticks) out << "<path d=\"M" << x.pixel(t.at) << ' ' << top << 'V' << height - bottom << "\"/>";
  for (const Tick& t : y_ticks) out << "<path d=\"M" << left << ' ' << y.pixel(t.at) << 'H' << width - right << "\"/>";
  out << "</g><path class=\"frame\" d=\"M" << left << ' ' << top << 'V' << height - bottom << 'H' << width - right
      << "\"/>\n<g class=\"ticks\">";
  for (const Tick& t : x_ticks)
    out << "<text text-anchor=\"middle\" x=\"" << x.pixel(t.at) << "\" y=\"" << height - bottom + 16 << "\">" << t.text
        << "</text>";
  for (const Tick& t : y_ticks)
    out << "<text text-anchor=\"end\" x=\"" << left - 6 << "\" y=\"" << y.pixel(t.at) + 4 << "\">" << t.text
        << "</text>";
  out << "</g>\n<text class=\"label\" text-anchor=\"middle\" x=\"" << (left + width - right) / 2 << "\" y=\""
      << height - 8 << "\">" << escaped(plot.x_label)
      << "</text><text class=\"label\" text-anchor=\"middle\" transform=\"translate(16 " << (top + height - bottom) / 2
      << ") rotate(-90)\">" << escaped(plot.y_label) << "</text>\n";
}

void write_legend(std::ostream& out, const Plot& plot, const std::vector<std::string>& classes) {
  out << "<ul class=\"legend\">";
  for (std::size_t i = 0; i < plot.curves.size(); ++i) {
    if (plot.curves[i].label.empty()) continue;
    const Curve& curve = plot.curves[i];
    const std::string_view sample = is_mark(curve) ? "M14 6h.01"
                                    : curve.points ? "M6 6h.01M14 6h.01M22 6h.01"
                                                   : "M2 6H26";
    out << "<li><svg viewBox=\"0 0 28 12\" width=\"28\" height=\"12\" aria-hidden=\"true\"><path class=\"" << classes[i]
        << "\" d=\"" << sample << "\"/></svg>" << escaped(plot.curves[i].label) << "</li>";
  }
  out << "</ul>\n";
}

void write_figure(std::ostream& out, const Plot& plot, const Canvas& canvas, const Axis& x, const Axis& y) {
  const std::vector<std::string> classes = classes_of(plot);
  out << "<figure><figcaption>" << escaped(plot.title) << "</figcaption>\n<svg viewBox=\"0 0 " << canvas.width << ' '
      << canvas.height << "\" fill=\"none\" role=\"img\" aria-label=\""
      << escaped(plot.title + ": " + plot.y_label + " against " + plot.x_label) << "\">\n";
  write_axes(out, plot, canvas, x, y);
  for (std::size_t i = 0; i < plot.curves.size(); ++i)
    out << "<path class=\"" << classes[i] << "\" d=\"" << path_data(plot.curves[i], x, y) << "\"/>\n";
  out << "</svg>\n";
  write_legend(out, plot, classes);
  out << "</figure>\n";
}

}  // namespace

std::string escaped(std::string_view text) {
  std::string safe;
  for (const char c : text) {
    switch (c) {
      case '&':
        safe += "&amp;";
        break;
      case '<':
        safe += "&lt;";
        break;
      case '>':
        safe += "&gt;";
        break;
      case '"':
        safe += "&quot;";
        break;
      default:
        safe += c;
    }
  }
  return safe;
}

std::string_view plot_style() {
  return R"(figure { margin: 1.5rem 0; break-inside: avoid; }
figcaption { font-weight: 600; margin-bottom: .3rem; }
.row { display: grid; grid-template-columns: repeat(auto-fit, minmax(17rem, 1fr)); gap: 0 1rem; align-items: end; }
.row figcaption { font-size: .9rem; }
figure > svg { width: 100%; height: auto; max-width: 60rem; display: block; }
figure path { fill: none; stroke-linejoin: round; stroke-linecap: round; }
figure text { fill: var(--ink); font: 12px system-ui, sans-serif; }
.grid path { stroke: var(--faint); stroke-width: 1; }
.frame { stroke: var(--ink); stroke-width: 1; }
.ticks { font-variant-numeric: tabular-nums; }
.line { stroke-width: 1.8; }
.dots { stroke-width: 3.4; stroke-opacity: .7; }
.mark { stroke-width: 9; }
.dash { stroke: var(--ink); stroke-width: 1.6; }
figure path.dash { stroke-linecap: butt; }
.dash-0 { stroke-dasharray: 6 4; } .dash-1 { stroke-dasharray: 2 3; }
.dash-2 { stroke-dasharray: 10 3 2 3; } .dash-3 { stroke-dasharray: 12 6; }
.series-0 { stroke: var(--series-0); } .series-1 { stroke: var(--series-1); }
.series-2 { stroke: var(--series-2); } .series-3 { stroke: var(--series-3); }
.series-4 { stroke: var(--series-4); } .series-5 { stroke: var(--series-5); }
.series-6 { stroke: var(--series-6); } .series-7 { stroke: var(--series-7); }
.legend { list-style: none; margin: .2rem 0 0; padding: 0; display: flex; flex-wrap: wrap; gap: .2rem 1.2rem; font-size: .85rem; }
.legend svg { vertical-align: middle; margin-right: .4rem; }
)";
}

std::string svg_figures(std::span<const Plot> row) {
  const bool alone = row.size() == 1;
  const Canvas canvas =
      alone ? Canvas{} : Canvas{std::max(least_width, page_width / static_cast<double>(row.size())), height_in_row};
  double y_most = 0;
  for (const Plot& plot : row) y_most = std::max(y_most, plot.y_most);
  constexpr double no_limit = std::numeric_limits<double>::infinity();
  bool has_marks = false;
  for (const Plot& plot : row) has_marks = has_marks || std::ranges::any_of(plot.curves, is_mark);
  const double x_air = has_marks ? 0.03 : 0;  // a mark at the edge would be cut
  const Axis x = axis_of(row, &Curve::x, false, left, canvas.width - right, x_air, no_limit);
  const Axis y = axis_of(row, &Curve::y, row.front().log_y, canvas.height - bottom, top, 0.05, y_most);
  std::ostringstream out;
  out.precision(5);
  if (!alone) out << "<div class=\"row\">\n";
  for (const Plot& plot : row) write_figure(out, plot, canvas, x, y);
  if (!alone) out << "</div>\n";
  return out.str();
}

}  // namespace downrange::experiment
