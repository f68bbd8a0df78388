#include "gluevo/vo/pipeline/track_votes.h"

#include <gtest/gtest.h>

#include <vector>

#include "gluevo/nn/error.h"

namespace gluevo::vo {
namespace {

constexpr int kWidth = 800;

TrackedFrame Frame(const std::vector<int64_t>& tracks) {
  TrackedFrame frame;
  for (const int64_t track : tracks) {
    Observation observation;
    observation.track_id = track;
    observation.left_pixel = {10.0 * static_cast<double>(track), 0.0};
    frame.observations.push_back(observation);
  }
  return frame;
}

double VoteOf(const TrackVotes& votes, int64_t track) {
  const TrackedFrame frame = Frame({track});
  const Observation* const seen[] = {&frame.observations[0]};
  PnpObservation points[1];
  votes.Assign(seen, kWidth, points);
  return points[0].vote;
}

TEST(TrackVotesTest, VotesGrowWithAgreement) {
  TrackVotes votes({.new_vote = 0.2, .full_after = 4});
  EXPECT_DOUBLE_EQ(VoteOf(votes, 1), 0.2);
  double last = 0.2;
  for (int i = 0; i < 4; ++i) {
    votes.Learn(Frame({1}), {PnpVerdict::kInlier});
    EXPECT_GT(VoteOf(votes, 1), last);
    last = VoteOf(votes, 1);
  }
  EXPECT_DOUBLE_EQ(last, 1.0);
  votes.Learn(Frame({1}), {PnpVerdict::kInlierLeft});
  EXPECT_DOUBLE_EQ(VoteOf(votes, 1), 1.0);
  // A track that is gone is forgotten.
  votes.Learn(Frame({2}), {PnpVerdict::kInlier});
  EXPECT_DOUBLE_EQ(VoteOf(votes, 1), 0.2);
}

TEST(TrackVotesTest, WhatDisagreesMovesAndWhatAgreedLongIsBelievedLonger) {
  TrackVotes votes({.full_after = 4, .strikes = 2});
  for (int i = 0; i < 6; ++i) {
    votes.Learn(Frame({1}), {PnpVerdict::kInlier});
  }
  const std::vector<std::optional<PnpVerdict>> both_wrong(2, PnpVerdict::kOutlier);
  votes.Learn(Frame({1, 2}), both_wrong);
  EXPECT_FALSE(votes.Moves(2));
  votes.Learn(Frame({1, 2}), both_wrong);
  EXPECT_TRUE(votes.Moves(2));
  votes.Learn(Frame({1, 2}), {PnpVerdict::kOutlier, std::nullopt});
  EXPECT_FALSE(votes.Moves(1));
  votes.Learn(Frame({1, 2}), {PnpVerdict::kOutlier, std::nullopt});
  EXPECT_TRUE(votes.Moves(1));
  EXPECT_TRUE(votes.Moves(2));
  votes.Clear();
  EXPECT_FALSE(votes.Moves(1));
}

TEST(TrackVotesTest, OneDisagreementIsForgiven) {
  TrackVotes votes({.strikes = 2});
  for (int i = 0; i < 4; ++i) {
    votes.Learn(Frame({1}), {i % 2 == 0 ? PnpVerdict::kOutlier : PnpVerdict::kInlier});
    EXPECT_FALSE(votes.Moves(1)) << i;
  }
}

TEST(TrackVotesTest, ACellHasNoMoreThanItsLimit) {
  const TrackVotes votes({.new_vote = 0.5, .cell_limit = 1.0, .cell_share = 0.125});
  // Cells of 100 pixels: four tracks in the first, one in the second.
  const TrackedFrame frame = Frame({1, 2, 3, 4, 15});
  std::vector<const Observation*> seen;
  seen.reserve(frame.observations.size());
  for (const Observation& observation : frame.observations) {
    seen.push_back(&observation);
  }
  std::vector<PnpObservation> points(seen.size());
  votes.Assign(seen, kWidth, points);
  EXPECT_DOUBLE_EQ(points[0].vote, 0.25);
  EXPECT_DOUBLE_EQ(points[4].vote, 0.5);
}

TEST(TrackVotesTest, OptionsAreChecked) {
  EXPECT_NO_THROW(VoteOptions().Validate());
  EXPECT_THROW(VoteOptions{.new_vote = 0.0}.Validate(), Error);
  EXPECT_THROW(VoteOptions{.strikes = -1}.Validate(), Error);
}

}  // namespace
}  // namespace gluevo::vo
