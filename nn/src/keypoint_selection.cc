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

  // Bands of rows collect their candidates, and of these the maxima, each in its own rows of a
  // buffer: the threads share the work, and the order is the image's.
  constexpr int64_t kBandRows = 16;
  const int64_t bands = (height + kBandRows - 1) / kBandRows;
  Arena& arena = workspace.arena;
  const TensorView<int32_t> candidates = arena.Allocate<int32_t>({height, width});
  const TensorView<int32_t> maxima = arena.Allocate<int32_t>({height, width});
  const TensorView<int64_t> candidate_counts = arena.Allocate<int64_t>({bands});
  const TensorView<int64_t> maximum_counts = arena.Allocate<int64_t>({bands});
  const auto for_bands = [&](const auto& f) {
    workspace.pool.ParallelFor(bands, [&](int64_t band, int /*worker*/) { f(band); });
  };
  const auto for_all = [&](TensorView<int32_t> points, TensorView<int64_t> counts, const auto& f) {
    for (int64_t band = 0; band < bands; ++band) {
      const int32_t* const of_band = points.data() + band * kBandRows * width;
      std::for_each(of_band, of_band + counts[band], f);
    }
  };

  enum State : uint8_t { kOpen = 0, kSuppressed = 1, kMaximum = 2 };
  const TensorView<uint8_t> state = arena.Allocate<uint8_t>({height, width});
  for_bands([&](int64_t band) {
    const int64_t begin = band * kBandRows * width;
    const int64_t end = std::min(scores.size(), begin + kBandRows * width);
    std::fill(state.data() + begin, state.data() + end, kOpen);
    int32_t* to = candidates.data() + begin;
    for (int64_t i = begin; i < end; ++i) {
      *to = static_cast<int32_t>(i);
      to += scores[i] > options.keypoint_threshold ? 1 : 0;
    }
    candidate_counts[band] = to - (candidates.data() + begin);
  });
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
  for (int round = 0; round < kRounds; ++round) {
    for_bands([&](int64_t band) {
      const int64_t begin = band * kBandRows * width;
      int64_t count = 0;
      for (int64_t k = begin; k < begin + candidate_counts[band]; ++k) {
        const int32_t i = candidates[k];
        bool largest = state[i] == kOpen;
        if (largest) {
          for_window(i, [&](int64_t j) {
            largest = scores[j] <= scores[i] || state[j] != kOpen;
            return largest;
          });
        }
        if (largest) {
          maxima[begin + count++] = i;
        }
      }
      maximum_counts[band] = count;
    });
    for_all(maxima, maximum_counts, [&](int64_t i) {
      for_window(i, [&](int64_t j) {
        if (state[j] == kOpen) {
          state[j] = kSuppressed;
        }
        return true;
      });
    });
    // After the painting: equal neighbours are maxima both.
    for_all(maxima, maximum_counts, [&](int64_t i) { state[i] = kMaximum; });
  }

  const auto dropped = [&](int64_t i) {
    const int64_t y = i / width;
    const int64_t x = i % width;
    return state[i] != kMaximum || y < options.border || x < options.border ||
           y >= height - options.border || x >= width - options.border;
  };
  keypoints.clear();
  // The most that any image of this size has, so that none asks for memory later.
  keypoints.reserve(static_cast<std::size_t>(scores.size()));
  for_all(candidates, candidate_counts, [&](int64_t i) {
    if (!dropped(i)) {
      keypoints.push_back(i);
    }
  });
  const auto better = [&](int64_t i, int64_t j) {
    return scores[i] != scores[j] ? scores[i] > scores[j] : i < j;
  };
  std::sort(keypoints.begin(), keypoints.end(), better);
  if (keypoints.size() > static_cast<std::size_t>(options.max_keypoints)) {
    keypoints.resize(static_cast<std::size_t>(options.max_keypoints));
  }
}

}  // namespace gluevo::nn
