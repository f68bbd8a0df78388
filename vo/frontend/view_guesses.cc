#include "view_guesses.h"

#include <limits>

#include "turned_view.h"

namespace gluevo::vo {

std::vector<cv::Point2f> GuessByView(const ExpectedView& view, const Camera& camera,
                                     const std::vector<int64_t>& ids,
                                     const std::vector<cv::Point2f>& pixels) {
  const std::vector<cv::Point2f> turned = TurnPixels(pixels, camera, view.now_from_last);
  std::vector<cv::Point2f> guesses = turned;
  std::vector<std::size_t> known, unknown;
  for (std::size_t i = 0; i < ids.size(); ++i) {
    const auto found = view.pixels.find(ids[i]);
    if (found == view.pixels.end()) {
      unknown.push_back(i);
      continue;
    }
    known.push_back(i);
    guesses[i] =
        cv::Point2f(static_cast<float>(found->second.x()), static_cast<float>(found->second.y()));
  }
  for (const std::size_t i : unknown) {
    float least = std::numeric_limits<float>::infinity();
    for (const std::size_t j : known) {
      const cv::Point2f offset = pixels[j] - pixels[i];
      if (offset.dot(offset) < least) {
        least = offset.dot(offset);
        guesses[i] = turned[i] + (guesses[j] - turned[j]);
      }
    }
  }
  return guesses;
}

}  // namespace gluevo::vo
