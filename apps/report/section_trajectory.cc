#include <Eigen/Geometry>

#include "markup.h"
#include "path_views.h"
#include "sections.h"

namespace gluevo::apps {

std::string TrajectorySection(const RunReport& report) {
  std::string html =
      "<section><h2>Trajectory</h2>\n<p class=\"legend\"><span class=\"key\"><svg class=\"swatch\" "
      "viewBox=\"0 0 24 10\"><line class=\"path estimate\" x1=\"1\" x2=\"23\" y1=\"5\" "
      "y2=\"5\"/></svg>estimate</span>";
  if (report.evaluation) {
    html +=
        "<span class=\"key\"><svg class=\"swatch\" viewBox=\"0 0 24 10\"><line class=\"path "
        "truth\" x1=\"1\" x2=\"23\" y1=\"5\" y2=\"5\"/></svg>ground truth</span>";
  }
  html +=
      "<span class=\"key\"><svg class=\"swatch\" viewBox=\"0 0 24 10\"><circle class=\"start\" "
      "cx=\"12\" cy=\"5\" r=\"4\"/></svg>start</span>";
  if (!report.frames.empty() && report.frames.back().segment > 0) {
    html +=
        "<span class=\"key\"><svg class=\"swatch\" viewBox=\"0 0 24 10\"><path class=\"reset\" "
        "d=\"M8 1l8 8m0-8l-8 8\"/></svg>tracking lost</span>";
  }
  html += "</p>\n";
  if (!report.evaluation) {
    const PathViews views = EstimateViews(report);
    return html + "<div class=\"columns\">" + DrawPathPicture(views.above) +
           DrawPathPicture(views.side) + "</div></section>\n";
  }
  const PathViews se3 = AlignedViews(report, /*with_scale=*/false);
  const PathViews sim3 = AlignedViews(report, /*with_scale=*/true);
  return html + "<div class=\"columns\"><div><h3>SE(3)-aligned: true to scale</h3>" +
         DrawPathPicture(se3.above) + DrawPathPicture(se3.side) +
         "</div><div><h3>Sim(3)-aligned: scaled by " + Fixed(report.evaluation->scale, 4) +
         "</h3>" + DrawPathPicture(sim3.above) + DrawPathPicture(sim3.side) +
         "</div></div></section>\n";
}

}  // namespace gluevo::apps
