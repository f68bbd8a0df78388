#include "gluevo/vo/mapping/place_index.h"

#include <algorithm>
#include <utility>

namespace gluevo::vo {

void PlaceIndex::Add(Eigen::VectorXf place) {
  rounded_.Add(place);
  places_.push_back(std::move(place));
}

std::vector<PlaceIndex::Similar> PlaceIndex::MostSimilar(const Eigen::VectorXf& place,
                                                         std::size_t among, std::size_t count,
                                                         double least) const {
  struct Candidate {
    std::size_t place = 0;
    float highest = 0.0F;     // What the similarity may be.
    bool is_refined = false;  // Whether that is by all bytes.
  };
  const auto is_less = [](const Candidate& a, const Candidate& b) { return a.highest < b.highest; };
  const auto is_before = [](const Similar& a, const Similar& b) {
    return a.similarity > b.similarity || (a.similarity == b.similarity && a.place < b.place);
  };
  const nn::ByteVectors::Rounded rounded = rounded_.Round(place);
  const std::vector<nn::ByteVectors::Bounds> bounds = rounded_.Products(rounded, among);
  std::vector<Candidate> candidates;  // A heap.
  for (std::size_t i = 0; i < among; ++i) {
    if (bounds[i].highest >= least) {
      candidates.push_back({i, bounds[i].highest});
    }
  }
  std::make_heap(candidates.begin(), candidates.end(), is_less);
  std::vector<Similar> best;
  while (!candidates.empty() && count > 0) {
    std::pop_heap(candidates.begin(), candidates.end(), is_less);
    Candidate& next = candidates.back();
    if (best.size() == count && next.highest < best.back().similarity) {
      break;
    }
    if (!next.is_refined) {
      next.is_refined = true;
      next.highest = std::min(next.highest, rounded_.Product(rounded, next.place).highest);
      std::push_heap(candidates.begin(), candidates.end(), is_less);
      continue;
    }
    const Similar similar{next.place, place.dot(places_[next.place])};
    candidates.pop_back();
    if (similar.similarity >= least) {
      best.insert(std::upper_bound(best.begin(), best.end(), similar, is_before), similar);
      best.resize(std::min(best.size(), count));
    }
  }
  return best;
}

}  // namespace gluevo::vo
