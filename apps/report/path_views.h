#pragma once

#include <cstddef>
#include <utility>
#include <vector>

#include "path_picture.h"
#include "run_report.h"

namespace gluevo::apps {

/// A trajectory seen from above and from the side.
struct PathViews {
  PathPicture above, side;
};

/// The estimate in its own world.
PathViews EstimateViews(const RunReport& report);

/// From above: the places, a line through them (broken between segments), and lines between those
/// of `pairs`. `places`: one a frame.
PathPicture LoopView(const RunReport& report, const std::vector<Eigen::Vector3d>& places,
                     const std::vector<std::pair<std::size_t, std::size_t>>& pairs);

/// The estimate, aligned by SE(3) or Sim(3), over the ground truth of the run's time. The views of
/// both alignments show the same part of the world. The report must have an evaluation.
PathViews AlignedViews(const RunReport& report, bool with_scale);

/// The poses that have a partner in the ground truth, coloured by their errors on a scale up to
/// `most` metres, seen from above.
PathPicture ErrorView(const RunReport& report, bool with_scale, double most);

}  // namespace gluevo::apps
