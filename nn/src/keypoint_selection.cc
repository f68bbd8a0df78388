#include <algorithm>

#include "gluevo/nn/superpoint.h"

namespace gluevo::nn {

// Published: on the whole map, mask = (s == maxpool(s)); then twice: points within the radius of
// the mask are suppressed (s = 0), and those equal to the max-pool of what is left join the mask. A
// point is compared with higher ones only, and the threshold drops all below it, so it is enough to
// visit the points above the threshold: the outcome for them is the same.
void SelectKeypoints(TensorView<const float> scores, const SuperPointOptions& options,
                     Workspace& workspace, std::vector<int64_t>& keypoints) {
  const int64_t height = scores.extent(0);
  const int64_t width = scores.extent(1);
  const int64_t radius = options.nms_radius;
  constexpr int kRounds = 3;

  keypoints.clear();
  // The most that any image of this size has, so that none asks for memory later.
  keypoints.reserve(static_cast<std::size_t>(scores.size()));
  for (int64_t i = 0; i < scores.size(); ++i) {
    if (scores[i] > options.keypoint_threshold) {
      keypoints.push_back(i);
    }
  }

  enum State : uint8_t { kOpen = 0, kSuppressed = 1, kMaximum = 2 };
  const TensorView<uint8_t> state = workspace.arena.Allocate<uint8_t>({height, width});
  std::fill_n(state.data(), state.size(), kOpen);
  const auto for_window = [&](int64_t i, const auto& f) {
    const int64_t y = i / width;
    const int64_t x = i % width;
    for (int64_t v = std::max<int64_t>(0, y - radius); v <= std::min(height - 1, y + radius); ++v) {
      for (int64_t u = std::max<int64_t>(0, x - radius); u <= std::min(width - 1, x + radius);
           ++u) {
        if (!f(v * width + u)) {
          return;
        }
      }
    }
  };
  const TensorView<int64_t> maxima =
      workspace.arena.Allocate<int64_t>({static_cast<int64_t>(keypoints.size())});
  for (int round = 0; round < kRounds; ++round) {
    int64_t count = 0;
    for (const int64_t i : keypoints) {
      bool largest = state[i] == kOpen;
      if (largest) {
        for_window(i, [&](int64_t j) {
          largest = scores[j] <= scores[i] || state[j] != kOpen;
          return largest;
        });
      }
      if (largest) {
        maxima[count++] = i;
      }
    }
    for (int64_t k = 0; k < count; ++k) {
      for_window(maxima[k], [&](int64_t j) {
        if (state[j] == kOpen) {
          state[j] = kSuppressed;
        }
        return true;
      });
    }
    // After the painting: equal neighbours are maxima both.
    for (int64_t k = 0; k < count; ++k) {
      state[maxima[k]] = kMaximum;
    }
  }

  const auto dropped = [&](int64_t i) {
    const int64_t y = i / width;
    const int64_t x = i % width;
    return state[i] != kMaximum || y < options.border || x < options.border ||
           y >= height - options.border || x >= width - options.border;
  };
  keypoints.erase(std::remove_if(keypoints.begin(), keypoints.end(), dropped), keypoints.end());
  const auto better = [&](int64_t i, int64_t j) {
    return scores[i] != scores[j] ? scores[i] > scores[j] : i < j;
  };
  std::sort(keypoints.begin(), keypoints.end(), better);
  if (keypoints.size() > static_cast<std::size_t>(options.max_keypoints)) {
    keypoints.resize(static_cast<std::size_t>(options.max_keypoints));
  }
}

}  // namespace gluevo::nn
