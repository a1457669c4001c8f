// A scatter plot with two logarithmic axes, as SVG.
#pragma once

#include <string>
#include <vector>

namespace pineda::tools {

struct PlotPoint {
  double x = 0, y = 0;     // > 0
  std::string label;       // short, beside the mark
  std::string title;       // the tooltip
  bool dominated = false;  // drawn hollow
};

enum class Mark { kCircle, kSquare, kTriangle, kDiamond };

struct PlotSeries {
  std::string name;
  std::string colour;  // CSS
  Mark mark = Mark::kCircle;
  std::vector<PlotPoint> points;  // joined by a line in this order
};

struct Plot {
  std::string title, x_label, y_label;
  std::vector<PlotSeries> series;
  double y_floor = 0;  // points below are drawn here, as "at most"; 0: the axis takes what it needs
};

// Ticks of a logarithmic axis that covers [low, high]: 1, 2 and 5 of each decade for short ranges, else decades.
std::vector<double> log_ticks(double low, double high);

std::string svg(const Plot& plot);  // stands alone, and in a page takes its colours from the style sheet's variables

}  // namespace pineda::tools
