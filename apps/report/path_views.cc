#include "path_views.h"

#include <algorithm>

#include "frame_series.h"
#include "markup.h"
#include "sections.h"

namespace gluevo::apps {
namespace {

Eigen::Vector3d Aligned(const vo::Similarity3& alignment, const Eigen::Vector3d& point) {
  return alignment.scale * (alignment.rigid.rotation * point) + alignment.rigid.translation;
}

vo::Similarity3 Alignment(const RunReport& report, bool with_scale) {
  return with_scale
             ? report.evaluation->groundtruth_world_from_estimate_world_sim3
             : vo::Similarity3{1.0, report.evaluation->groundtruth_world_from_estimate_world};
}

// Cameras are mostly held upright: up is where, on average, the top of the left image points.
Eigen::Vector3d TopOfImage(const RunReport& report, const vo::Rigid3& world_from_body) {
  return world_from_body.rotation *
         (report.rig.body_from_cam[0].rotation * -Eigen::Vector3d::UnitY());
}

Path EstimatePath(const RunReport& report, const vo::Similarity3& alignment) {
  Path path{"path estimate", {}, {}, {}};
  for (std::size_t i = 0; i < report.frames.size(); ++i) {
    if (i > 0 && report.frames[i].segment != report.frames[i - 1].segment) {
      path.breaks.push_back(i);
    }
    path.points.push_back(Aligned(alignment, report.frames[i].world_from_body.translation));
  }
  return path;
}

std::vector<PathMark> Marks(const RunReport& report, const Path& estimate) {
  std::vector<PathMark> marks;
  for (const std::size_t i : estimate.breaks) {
    marks.push_back({estimate.points[i], "reset",
                     "tracking lost at frame " + std::to_string(i) + ", " +
                         Fixed(SecondsIn(report, report.frames[i].timestamp_ns), 1) + " s"});
  }
  if (!estimate.points.empty()) {
    marks.push_back({estimate.points.front(), "start", "start"});
  }
  return marks;
}

// The ground truth while the run lasts, and whether its camera's top is up.
struct Truth {
  Path path{"path truth", {}, {}, {}};
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
};

Truth TruthOf(const RunReport& report) {
  Truth truth;
  for (const vo::StampedPose& pose : *report.groundtruth) {
    if (!report.frames.empty() && pose.timestamp_ns >= report.frames.front().timestamp_ns &&
        pose.timestamp_ns <= report.frames.back().timestamp_ns) {
      truth.path.points.push_back(pose.world_from_body.translation);
      truth.up += TopOfImage(report, pose.world_from_body);
    }
  }
  return truth;
}

Eigen::AlignedBox3d BoxOf(const std::vector<Path>& paths) {
  Eigen::AlignedBox3d box;
  for (const Path& path : paths) {
    for (const Eigen::Vector3d& point : path.points) {
      box.extend(point);
    }
  }
  if (box.isEmpty()) {
    box.extend(Eigen::Vector3d::Zero());
  }
  return box;
}

PathViews Views(const ViewAxes& axes, const Eigen::AlignedBox3d& box,
                const std::vector<Path>& paths, const std::vector<PathMark>& marks) {
  PathViews views;
  views.above = {"From above", axes.right, axes.forward, box, paths, marks, 1.0, ""};
  views.side = {"From the side", axes.right, axes.up, box, paths, marks, 1.0, ""};
  return views;
}

// What both alignments are shown in.
struct Stage {
  Truth truth;
  Eigen::AlignedBox3d box;
  ViewAxes axes;
};

Stage StageOf(const RunReport& report) {
  Stage stage{TruthOf(report), {}, {}};
  stage.box = BoxOf({stage.truth.path, EstimatePath(report, Alignment(report, false)),
                     EstimatePath(report, Alignment(report, true))});
  stage.axes = ChooseViewAxes(stage.truth.up, stage.box);
  return stage;
}

}  // namespace

PathViews EstimateViews(const RunReport& report) {
  const Path estimate = EstimatePath(report, {});
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const vo::FrameResult& frame : report.frames) {
    up += TopOfImage(report, frame.world_from_body);
  }
  const Eigen::AlignedBox3d box = BoxOf({estimate});
  return Views(ChooseViewAxes(up, box), box, {estimate}, Marks(report, estimate));
}

PathPicture LoopView(const RunReport& report, const std::vector<Eigen::Vector3d>& places,
                     const std::vector<std::pair<std::size_t, std::size_t>>& pairs) {
  Path way = EstimatePath(report, {});
  way.points = places;
  Eigen::Vector3d up = Eigen::Vector3d::Zero();
  for (const vo::FrameResult& frame : report.frames) {
    up += TopOfImage(report, frame.world_from_body);
  }
  const Eigen::AlignedBox3d box = BoxOf({way});
  std::vector<Path> paths = {way};
  for (const auto& [a, b] : pairs) {
    paths.push_back({"path loop", {places[a], places[b]}, {}, {}});
  }
  return Views(ChooseViewAxes(up, box), box, paths, {}).above;
}

PathViews AlignedViews(const RunReport& report, bool with_scale) {
  const Stage stage = StageOf(report);
  const Path estimate = EstimatePath(report, Alignment(report, with_scale));
  return Views(stage.axes, stage.box, {stage.truth.path, estimate}, Marks(report, estimate));
}

PathPicture ErrorView(const RunReport& report, bool with_scale, double most) {
  const Stage stage = StageOf(report);
  Path path{"", {}, ErrorBreaks(report), {}};
  for (const vo::PoseError& error : report.evaluation->errors) {
    path.points.push_back(with_scale ? error.sim3 : error.se3);
    path.values.push_back(with_scale ? error.sim3_m : error.se3_m);
  }
  PathPicture picture = Views(stage.axes, stage.box, {path}, {}).above;
  picture.title = with_scale ? "Along the path, Sim(3)-aligned" : "Along the path, SE(3)-aligned";
  picture.most = most;
  picture.value_unit = "m off";
  return picture;
}

}  // namespace gluevo::apps
