#pragma once

#include <cstdint>
#include <optional>
#include <span>
#include <unordered_map>
#include <vector>

#include "gluevo/vo/core/tracked_frame.h"
#include "gluevo/vo/geometry/pnp.h"

namespace gluevo::vo {

/// How much each track has to say in the pose of a frame, and which tracks are taken for things
/// that move by themselves.
struct VoteOptions {
  /// A track that nothing is known of has this vote, one that agreed with so many poses in
  /// sequence has a whole one; between them votes grow evenly.
  double new_vote = 0.2;
  int full_after = 5;
  /// Votes that the tracks of one cell of the image have together, at most. 0: no limit.
  double cell_limit = 0.0;
  /// Side of a cell, as a share of the image's width.
  double cell_share = 0.125;
  /// A track that disagrees so often in sequence moves by itself, and is kept out of the estimate.
  /// Each pose that it agreed with before, up to full_after, is worth half a disagreement more.
  /// 0: none is kept out. Once is not enough: where a point's first stereo match was wrong it is
  /// its landmark that disagrees, which starts anew from the next one.
  int strikes = 2;
  /// Where the tracks that agree have a smaller share of all votes, a pose is doubtful.
  double doubtful_share = 0.5;

  /// Throws Error naming the option.
  void Validate() const;
};

/// What tracks did in the frames before. The motion that most points share need not be that of the
/// rig: a van that passes close has the most points for a second. But it has not had them for long:
/// a point that agreed with the poses of many frames stands still.
class TrackVotes {
 public:
  explicit TrackVotes(const VoteOptions& options) : options_(options) {}

  /// Sets the votes of points, each seen by the track of that number at `left_pixels` of an image
  /// `width` pixels wide.
  void Assign(std::span<const Observation* const> observations, int width,
              std::span<PnpObservation> points) const;
  bool Moves(int64_t track_id) const;

  /// What became of the frame's tracks: one verdict an observation, where it was judged. A right
  /// view that does not fit is a disagreement, too, where most right views fit: what crosses the
  /// view looks to the left camera like a point at another depth. Tracks that the frame does not
  /// have are forgotten.
  void Learn(const TrackedFrame& frame, const std::vector<std::optional<PnpVerdict>>& verdicts);
  void Clear() { records_.clear(); }

 private:
  struct Record {
    int agreed = 0;
    int disagreed = 0;  // Since it last agreed.
    bool moves = false;
  };
  double VoteOf(int64_t track_id) const;

  VoteOptions options_;
  std::unordered_map<int64_t, Record> records_;
};

}  // namespace gluevo::vo
