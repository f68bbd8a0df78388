#include "gluevo/vo/pipeline/track_votes.h"

#include <algorithm>
#include <cmath>
#include <map>
#include <utility>

#include "gluevo/vo/core/options_check.h"

namespace gluevo::vo {
namespace {

bool RightDisagrees(const Observation& observation, std::optional<PnpVerdict> verdict) {
  return observation.has_right && verdict == PnpVerdict::kInlierLeft;
}

// Where most right views disagree it is the right image that is wrong, not the points.
bool RightIsBelieved(const TrackedFrame& frame,
                     const std::vector<std::optional<PnpVerdict>>& verdicts) {
  int with_right = 0;
  int disagree = 0;
  for (std::size_t i = 0; i < verdicts.size(); ++i) {
    const bool fits = verdicts[i] && verdicts[i] != PnpVerdict::kOutlier;
    with_right += fits && frame.observations[i].has_right ? 1 : 0;
    disagree += RightDisagrees(frame.observations[i], verdicts[i]) ? 1 : 0;
  }
  return 2 * disagree < with_right;
}

}  // namespace

void VoteOptions::Validate() const {
  CheckWithin(new_vote, 1e-3, 1.0, "votes.new_vote");
  CheckAtLeast(full_after, 1, "votes.full_after");
  CheckWithin(cell_limit, 0.0, 1e6, "votes.cell_limit");
  CheckWithin(cell_share, 1e-3, 1.0, "votes.cell_share");
  CheckAtLeast(strikes, 0, "votes.strikes");
  CheckWithin(doubtful_share, 0.0, 1.0, "votes.doubtful_share");
}

double TrackVotes::VoteOf(int64_t track_id) const {
  const auto found = records_.find(track_id);
  const int agreed =
      found != records_.end() ? std::min(found->second.agreed, options_.full_after) : 0;
  return options_.new_vote + (1.0 - options_.new_vote) * agreed / options_.full_after;
}

void TrackVotes::Assign(std::span<const Observation* const> observations, int width,
                        std::span<PnpObservation> points) const {
  using Cell = std::pair<int, int>;
  std::map<Cell, double> sums;
  const auto cell_of = [&](const Observation& observation) {
    const double side = options_.cell_share * width;
    return Cell(static_cast<int>(std::floor(observation.left_pixel.x() / side)),
                static_cast<int>(std::floor(observation.left_pixel.y() / side)));
  };
  for (std::size_t i = 0; i < points.size(); ++i) {
    points[i].vote = VoteOf(observations[i]->track_id);
    sums[cell_of(*observations[i])] += points[i].vote;
  }
  if (options_.cell_limit > 0.0) {
    for (std::size_t i = 0; i < points.size(); ++i) {
      points[i].vote *= std::min(1.0, options_.cell_limit / sums[cell_of(*observations[i])]);
    }
  }
}

bool TrackVotes::Moves(int64_t track_id) const {
  const auto found = records_.find(track_id);
  return found != records_.end() && found->second.moves;
}

void TrackVotes::Learn(const TrackedFrame& frame,
                       const std::vector<std::optional<PnpVerdict>>& verdicts) {
  const bool right_is_believed = RightIsBelieved(frame, verdicts);
  std::unordered_map<int64_t, Record> records;
  records.reserve(frame.observations.size());
  for (std::size_t i = 0; i < frame.observations.size(); ++i) {
    const int64_t track_id = frame.observations[i].track_id;
    const auto before = records_.find(track_id);
    Record record = before != records_.end() ? before->second : Record();
    const bool right_disagrees = RightDisagrees(frame.observations[i], verdicts[i]);
    if (verdicts[i] == PnpVerdict::kOutlier || (right_disagrees && right_is_believed)) {
      ++record.disagreed;
      const int credit = std::min(record.agreed, options_.full_after) / 2;
      record.moves =
          record.moves || (options_.strikes > 0 && record.disagreed >= options_.strikes + credit);
    } else if (verdicts[i] && !right_disagrees) {
      // What it did wrong once it may have done by a wrong match.
      record.agreed = record.disagreed > 0 ? record.agreed / 2 + 1 : record.agreed + 1;
      record.disagreed = 0;
    }
    records[track_id] = record;
  }
  records_ = std::move(records);
}

}  // namespace gluevo::vo
