#include "tools/accuracy/plot.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "tools/html.h"

namespace pineda::tools {
namespace {

constexpr double kWidth = 620, kHeight = 430, kLeft = 74, kRight = 26, kTop = 44, kBottom = 92;
constexpr double kLegendStep = 140;

struct Axis {
  double low, high, from, to;  // values, and the places of their ends

  double place(double value) const {
    const double share = (std::log(value) - std::log(low)) / (std::log(high) - std::log(low));
    return from + std::clamp(share, 0.0, 1.0) * (to - from);
  }
};

Axis axis_of(std::vector<double> values, double from, double to) {
  std::erase_if(values, [](double value) { return !(value > 0); });
  if (values.empty()) values = {1};
  const auto [low, high] = std::ranges::minmax(values);
  const double margin = std::max(std::pow(high / low, 0.07), 1.15);
  return {low / margin, high * margin, from, to};
}

std::string number_text(double value) {
  if (value >= 1e-3 && value < 1e4) return fmt::format("{:g}", value);
  const int exponent = static_cast<int>(std::floor(std::log10(value) + 1e-9));
  const double mantissa = value / std::pow(10.0, exponent);
  const std::string power = fmt::format("10<tspan dy='-5' font-size='9'>{}</tspan>", exponent);
  return std::abs(mantissa - 1) < 1e-6 ? power : fmt::format("{:.0f}·{}", mantissa, power);
}

class Drawing {
 public:
  explicit Drawing(const Plot& plot) : plot_(plot) {
    std::vector<double> xs, ys;
    for (const PlotSeries& series : plot.series) {
      for (const PlotPoint& point : series.points) {
        xs.push_back(point.x);
        ys.push_back(std::max(point.y, plot.y_floor));
      }
    }
    x_ = axis_of(xs, kLeft, kWidth - kRight);
    y_ = axis_of(ys, kHeight - kBottom, kTop);
  }

  std::string draw() {
    add("<svg xmlns='http://www.w3.org/2000/svg' viewBox='0 0 {} {}' font-family='system-ui, sans-serif' font-size='12' "
        "style='color: var(--text, #1d2330)'>\n<text x='{}' y='22' font-size='14' font-weight='600' "
        "fill='currentColor'>{}</text>\n",
        kWidth, kHeight, kLeft, escape_html(plot_.title));
    add_grid();
    for (const PlotSeries& series : plot_.series) add_line(series);
    for (const PlotSeries& series : plot_.series) add_points(series);
    add_legend();
    add("</svg>\n");
    return std::move(svg_);
  }

 private:
  template <typename... Args>
  void add(fmt::format_string<Args...> format, Args&&... args) {
    fmt::format_to(std::back_inserter(svg_), format, std::forward<Args>(args)...);
  }

  double y_of(const PlotPoint& point) const { return y_.place(std::max(point.y, plot_.y_floor)); }

  void add_grid() {
    const double bottom = kHeight - kBottom, right = kWidth - kRight;
    for (const double tick : log_ticks(x_.low, x_.high)) {
      const double x = x_.place(tick);
      add("<path d='M{0:.1f} {1}V{2}' stroke='var(--line, #e2e6ed)'/><text x='{0:.1f}' y='{3}' text-anchor='middle' "
          "fill='var(--soft, "
          "#626c7e)'>{4}</text>\n",
          x, kTop, bottom, bottom + 18, number_text(tick));
    }
    for (const double tick : log_ticks(y_.low, y_.high)) {
      const double y = y_.place(tick);
      add("<path d='M{0} {1:.1f}H{2}' stroke='var(--line, #e2e6ed)'/><text x='{3}' y='{4:.1f}' text-anchor='end' "
          "fill='var(--soft, "
          "#626c7e)'>{5}</text>\n",
          kLeft, y, right, kLeft - 8, y + 4, number_text(tick));
    }
    add("<path d='M{} {}V{}H{}' fill='none' stroke='var(--soft, #626c7e)'/>\n", kLeft, kTop, bottom, right);
    add("<text x='{:.1f}' y='{}' text-anchor='middle' fill='currentColor'>{}</text>\n", (kLeft + right) / 2, bottom + 38,
        escape_html(plot_.x_label));
    add("<text transform='translate(16 {:.1f}) rotate(-90)' text-anchor='middle' fill='currentColor'>{}</text>\n",
        (kTop + bottom) / 2, escape_html(plot_.y_label));
  }

  void add_line(const PlotSeries& series) {
    std::string path;
    for (const PlotPoint& point : series.points)
      path += fmt::format("{}{:.1f} {:.1f}", path.empty() ? "M" : "L", x_.place(point.x), y_of(point));
    add("<path d='{}' fill='none' stroke='{}' stroke-width='1.5' opacity='0.45'/>\n", path, series.colour);
  }

  void add_points(const PlotSeries& series) {
    for (const PlotPoint& point : series.points) {
      const double x = x_.place(point.x), y = y_of(point);
      add("<g><title>{}</title>", escape_html(point.title));
      add_mark(series, x, y, point.dominated);
      add("</g>");
      if (!place_label(x, y)) continue;
      add("<text x='{:.1f}' y='{:.1f}' font-size='11' fill='{}'>{}</text>\n", x + 7, y - 6, series.colour,
          escape_html(point.label));
    }
  }

  // A label beside one that says the same thing would only blot both.
  bool place_label(double x, double y) {
    const bool free = std::ranges::none_of(
        labels_, [&](const auto& other) { return std::abs(other.first - x) < 16 && std::abs(other.second - y) < 11; });
    if (free) labels_.emplace_back(x, y);
    return free;
  }

  void add_mark(const PlotSeries& series, double x, double y, bool hollow) {
    const std::string paint =
        fmt::format("fill='{}' stroke='{}' stroke-width='1.8'", hollow ? "var(--card, #ffffff)" : series.colour, series.colour);
    switch (series.mark) {
      case Mark::kCircle:
        add("<circle cx='{:.1f}' cy='{:.1f}' r='4.6' {}/>", x, y, paint);
        break;
      case Mark::kSquare:
        add("<rect x='{:.1f}' y='{:.1f}' width='8.4' height='8.4' {}/>", x - 4.2, y - 4.2, paint);
        break;
      case Mark::kTriangle:
        add("<path d='M{:.1f} {:.1f}l5.4 9.4h-10.8z' {}/>", x, y - 5.6, paint);
        break;
      case Mark::kDiamond:
        add("<path d='M{:.1f} {:.1f}l5.8 5.8l-5.8 5.8l-5.8 -5.8z' {}/>", x, y - 5.8, paint);
        break;
    }
  }

  void add_legend() {
    const double y = kHeight - 26;
    double x = kLeft + 6;
    for (const PlotSeries& series : plot_.series) {
      add_mark(series, x, y, false);
      add("<text x='{:.1f}' y='{:.1f}' fill='currentColor'>{}</text>\n", x + 10, y + 4, escape_html(series.name));
      x += kLegendStep;
    }
    add("<text x='{}' y='{}' fill='var(--soft, #626c7e)' font-size='11'>Numbers: samples a pixel. Hollow: dominated, something "
        "else is "
        "faster and nearer.</text>\n",
        kLeft, kHeight - 6);
  }

  const Plot& plot_;
  Axis x_, y_;
  std::vector<std::pair<double, double>> labels_;
  std::string svg_;
};

}  // namespace

std::vector<double> log_ticks(double low, double high) {
  const double decades = std::log10(high / low);
  std::vector<double> ticks;
  const int step = decades > 8 ? 2 : 1;
  for (int exponent = static_cast<int>(std::floor(std::log10(low))); exponent <= std::ceil(std::log10(high)); ++exponent) {
    if (exponent % step != 0) continue;
    for (const int mantissa : {1, 2, 5}) {
      if (mantissa != 1 && decades > 2.5) continue;
      const double tick = mantissa * std::pow(10.0, exponent);
      if (tick >= low && tick <= high) ticks.push_back(tick);
    }
  }
  return ticks;
}

std::string svg(const Plot& plot) { return Drawing(plot).draw(); }

}  // namespace pineda::tools
