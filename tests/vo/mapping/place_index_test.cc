#include "gluevo/vo/mapping/place_index.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <vector>

namespace gluevo::vo {
namespace {

constexpr int kValues = 300;

// Along a path: neighbours are alike, and the second half comes back to the first. Some are there
// twice, to the last bit.
std::vector<Eigen::VectorXf> PlacesAlongAPath(int count) {
  std::mt19937 random(2);
  std::normal_distribution<float> normal;
  const auto noise = [&] {
    Eigen::VectorXf vector(kValues);
    for (float& value : vector) {
      value = normal(random);
    }
    return vector;
  };
  std::vector<Eigen::VectorXf> places;
  Eigen::VectorXf place = noise();
  for (int i = 0; i < count; ++i) {
    place = 0.9F * place + 0.4F * noise();
    const bool comes_back = 2 * i >= count;
    const Eigen::VectorXf seen =
        comes_back ? Eigen::VectorXf(places[i - count / 2] + 0.02F * noise()) : place;
    places.push_back(i % 7 == 6 ? places[i - 6] : Eigen::VectorXf(seen.normalized()));
  }
  return places;
}

PlaceIndex IndexOf(const std::vector<Eigen::VectorXf>& places) {
  PlaceIndex index;
  for (const Eigen::VectorXf& place : places) {
    index.Add(place);
  }
  return index;
}

std::vector<PlaceIndex::Similar> ComparedWithAll(const std::vector<Eigen::VectorXf>& places,
                                                 const Eigen::VectorXf& place, std::size_t among,
                                                 std::size_t count, double least) {
  std::vector<PlaceIndex::Similar> all;
  for (std::size_t i = 0; i < among; ++i) {
    if (const double similarity = place.dot(places[i]); similarity >= least) {
      all.push_back({i, similarity});
    }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const auto& a, const auto& b) { return a.similarity > b.similarity; });
  all.resize(std::min(all.size(), count));
  return all;
}

TEST(PlaceIndex, FindsWhatComparingWithAllFinds) {
  const std::vector<Eigen::VectorXf> places = PlacesAlongAPath(200);
  const PlaceIndex index = IndexOf(places);
  ASSERT_EQ(index.size(), places.size());
  for (const double least : {-2.0, 0.1, 0.6}) {
    for (const std::size_t count : {0U, 1U, 3U, 200U, 300U}) {
      for (std::size_t i = 0; i < places.size(); i += 3) {
        for (const std::size_t among : {i, places.size()}) {
          const auto found = index.MostSimilar(places[i], among, count, least);
          const auto expected = ComparedWithAll(places, places[i], among, count, least);
          ASSERT_EQ(found.size(), expected.size());
          for (std::size_t k = 0; k < found.size(); ++k) {
            ASSERT_EQ(found[k].place, expected[k].place) << i << " " << k;
            ASSERT_EQ(found[k].similarity, expected[k].similarity);
          }
        }
      }
    }
  }
}

TEST(PlaceIndex, OfImagesWithoutKeypointsNoneIsLikeAnother) {
  const PlaceIndex index =
      IndexOf({Eigen::VectorXf::Zero(kValues), Eigen::VectorXf::Unit(kValues, 3)});
  EXPECT_TRUE(index.MostSimilar(index[0], 2, 3, 0.1).empty());
  EXPECT_EQ(index.MostSimilar(index[0], 2, 3).size(), 2U);
}

}  // namespace
}  // namespace gluevo::vo
