#pragma once

#include <cstdint>
#include <opencv2/core/types.hpp>
#include <vector>

#include "gluevo/vo/core/expected_view.h"
#include "gluevo/vo/geometry/camera.h"

namespace gluevo::vo {

/// Where the left image may show tracks that the last one showed at `pixels`, `ids` one each, for
/// optical flow to begin: where `view` says. Tracks of which it says nothing follow the camera's
/// turn, and on as the nearest one of which it does.
std::vector<cv::Point2f> GuessByView(const ExpectedView& view, const Camera& camera,
                                     const std::vector<int64_t>& ids,
                                     const std::vector<cv::Point2f>& pixels);

}  // namespace gluevo::vo
