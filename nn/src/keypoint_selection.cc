#include <algorithm>
#include <functional>

#include "gluevo/nn/superpoint.h"

namespace gluevo::nn {
namespace {

// Published: on the whole map, mask = (s == maxpool(s)); then twice: points within the radius of
// the mask are suppressed (s = 0), and those equal to the max-pool of what is left join the mask. A
// point is compared with higher ones only, and the threshold drops all below it, so it is enough to
// visit the points above the threshold: the outcome for them is the same.
//
// Bands of rows collect their candidates, and of these the maxima, each in its own rows of a
// buffer: the threads share the work, and the order is the image's.
class NonMaximumSuppression {
 public:
  NonMaximumSuppression(TensorView<const float> scores, int radius, Workspace& workspace)
      : scores_(scores),
        height_(scores.extent(0)),
        width_(scores.extent(1)),
        radius_(radius),
        bands_((height_ + kBandRows - 1) / kBandRows),
        pool_(workspace.pool),
        candidates_(workspace.arena, height_, width_, bands_),
        maxima_(workspace.arena, height_, width_, bands_),
        state_(workspace.arena.Allocate<uint8_t>({height_, width_})) {}

  void Run(float threshold) {
    CollectCandidates(threshold);
    constexpr int kRounds = 3;
    for (int round = 0; round < kRounds; ++round) {
      FindMaxima();
      SuppressAroundMaxima();
    }
  }

  // Calls f(point) for the points that are left, in order of position.
  template <typename F>
  void ForEachMaximum(const F& f) const {
    ForEach(candidates_, [&](int64_t i) {
      if (state_[i] == kMaximum) {
        f(i);
      }
    });
  }

 private:
  static constexpr int64_t kBandRows = 16;
  enum State : uint8_t { kOpen = 0, kSuppressed = 1, kMaximum = 2 };

  struct Points {
    Points(Arena& arena, int64_t height, int64_t width, int64_t bands)
        : indices(arena.Allocate<int32_t>({height, width})),
          counts(arena.Allocate<int64_t>({bands})) {}

    TensorView<int32_t> indices;  // Of each band from its first pixel on.
    TensorView<int64_t> counts;   // Of each band.
  };

  template <typename F>
  void ForEachBand(const F& f) {
    pool_.ParallelFor(bands_, [&](int64_t band, int /*worker*/) { f(band); });
  }

  template <typename F>
  void ForEach(const Points& points, const F& f) const {
    for (int64_t band = 0; band < bands_; ++band) {
      const int32_t* const of_band = points.indices.data() + band * kBandRows * width_;
      std::for_each(of_band, of_band + points.counts[band], f);
    }
  }

  // Calls f for the points within the radius until one returns false.
  template <typename F>
  void ForWindow(int64_t i, const F& f) const {
    const int64_t y = i / width_;
    const int64_t x = i % width_;
    const int64_t bottom = std::min(height_ - 1, y + radius_);
    const int64_t right = std::min(width_ - 1, x + radius_);
    for (int64_t v = std::max<int64_t>(0, y - radius_); v <= bottom; ++v) {
      for (int64_t u = std::max<int64_t>(0, x - radius_); u <= right; ++u) {
        if (!f(v * width_ + u)) {
          return;
        }
      }
    }
  }

  // Most pixels are far below the threshold: runs of them are left out at once.
  static constexpr int64_t kRun = 16;
  static bool AnyAbove(const float* run, float threshold) {
    uint32_t any = 0;
    for (int64_t i = 0; i < kRun; ++i) {
      any |= run[i] > threshold ? 1U : 0U;
    }
    return any != 0;
  }

  void CollectCandidates(float threshold) {
    ForEachBand([&](int64_t band) {
      const int64_t begin = band * kBandRows * width_;
      const int64_t end = std::min(scores_.size(), begin + kBandRows * width_);
      std::fill(state_.data() + begin, state_.data() + end, kOpen);
      int32_t* const first = candidates_.indices.data() + begin;
      int32_t* to = first;
      const auto collect = [&](int64_t i) {
        *to = static_cast<int32_t>(i);
        to += scores_[i] > threshold ? 1 : 0;
      };
      int64_t i = begin;
      for (; i + kRun <= end; i += kRun) {
        if (AnyAbove(scores_.data() + i, threshold)) {
          for (int64_t j = i; j < i + kRun; ++j) {
            collect(j);
          }
        }
      }
      for (; i < end; ++i) {
        collect(i);
      }
      candidates_.counts[band] = to - first;
    });
  }

  // The window decides; but scores are smooth, so that nearly all points that are no maxima have a
  // higher one right beside them.
  bool HasHigherNeighbour(int64_t i) const {
    const int64_t x = i % width_;
    const auto is_higher = [&](int64_t j) { return scores_[j] > scores_[i] && state_[j] == kOpen; };
    return radius_ > 0 && ((x > 0 && is_higher(i - 1)) || (x + 1 < width_ && is_higher(i + 1)) ||
                           (i >= width_ && is_higher(i - width_)) ||
                           (i + width_ < scores_.size() && is_higher(i + width_)));
  }

  void FindMaxima() {
    ForEachBand([&](int64_t band) {
      const int64_t begin = band * kBandRows * width_;
      int64_t count = 0;
      for (int64_t k = begin; k < begin + candidates_.counts[band]; ++k) {
        const int32_t i = candidates_.indices[k];
        bool largest = state_[i] == kOpen && !HasHigherNeighbour(i);
        if (largest) {
          ForWindow(i, [&](int64_t j) {
            largest = scores_[j] <= scores_[i] || state_[j] != kOpen;
            return largest;
          });
        }
        if (largest) {
          maxima_.indices[begin + count++] = i;
        }
      }
      maxima_.counts[band] = count;
    });
  }

  void SuppressAroundMaxima() {
    ForEach(maxima_, [&](int64_t i) {
      ForWindow(i, [&](int64_t j) {
        if (state_[j] == kOpen) {
          state_[j] = kSuppressed;
        }
        return true;
      });
    });
    // After the painting: equal neighbours are maxima both.
    ForEach(maxima_, [&](int64_t i) { state_[i] = kMaximum; });
  }

  TensorView<const float> scores_;
  int64_t height_;
  int64_t width_;
  int64_t radius_;
  int64_t bands_;
  ThreadPool& pool_;
  Points candidates_;
  Points maxima_;
  TensorView<uint8_t> state_;
};

// A score that about so many pixels exceed, by a sample of them.
float ScoreOfRank(TensorView<const float> scores, double rank, Arena& arena) {
  constexpr int64_t kStride = 61;  // Prime: no column of an image is left out.
  const TensorView<float> sample = arena.Allocate<float>({(scores.size() + kStride - 1) / kStride});
  const double of_sample = rank / kStride;
  if (of_sample >= static_cast<double>(sample.size())) {
    return 0.0F;
  }
  for (int64_t i = 0; i < sample.size(); ++i) {
    sample[i] = std::max(0.0F, scores[i * kStride]);  // 0 for what is no number, too.
  }
  float* const at = sample.data() + static_cast<std::ptrdiff_t>(of_sample);
  std::nth_element(sample.data(), at, sample.data() + sample.size(), std::greater<>());
  return *at;
}

}  // namespace

void SelectKeypoints(TensorView<const float> scores, const SuperPointOptions& options,
                     Workspace& workspace, std::vector<int64_t>& keypoints) {
  NonMaximumSuppression suppression(scores, options.nms_radius, workspace);
  const int64_t height = scores.extent(0);
  const int64_t width = scores.extent(1);
  // The most that any image of this size has, so that none asks for memory later.
  keypoints.reserve(static_cast<std::size_t>(scores.size()));
  const auto collect = [&](float threshold) {
    suppression.Run(threshold);
    keypoints.clear();
    suppression.ForEachMaximum([&](int64_t i) {
      const int64_t y = i / width;
      const int64_t x = i % width;
      if (y >= options.border && x >= options.border && y < height - options.border &&
          x < width - options.border) {
        keypoints.push_back(i);
      }
    });
  };
  // Where a higher threshold leaves as many as are wanted, they are those of the lower one, and
  // most pixels need not be visited.
  constexpr double kPixelsPerPeak = 30.0;
  const auto wanted = static_cast<std::size_t>(options.max_keypoints);
  const float threshold =
      std::max(options.keypoint_threshold,
               ScoreOfRank(scores, kPixelsPerPeak * options.max_keypoints, workspace.arena));
  collect(threshold);
  if (keypoints.size() < wanted && threshold > options.keypoint_threshold) {
    collect(options.keypoint_threshold);
  }
  const auto better = [&](int64_t i, int64_t j) {
    return scores[i] != scores[j] ? scores[i] > scores[j] : i < j;
  };
  const auto kept =
      keypoints.begin() + static_cast<std::ptrdiff_t>(std::min(keypoints.size(), wanted));
  std::nth_element(keypoints.begin(), kept, keypoints.end(), better);
  std::sort(keypoints.begin(), kept, better);
  keypoints.erase(kept, keypoints.end());
}

}  // namespace gluevo::nn
