#pragma once

#include <algorithm>
#include <array>
#include <cstdint>
#include <type_traits>

#include "gluevo/nn/arena.h"
#include "graph_network.h"
#include "graph_network_bands.h"
#include "step_progress.h"

namespace gluevo::nn {

/// What the layers know of one image; all of it is in an arena.
template <typename Element>
struct GraphNetwork<Element>::Image {
  /// Layers whose keys and values are kept: of one that the last bands are still at, of the next,
  /// which others have begun, and of the one after that, which these write.
  static constexpr int kKeySets = 3;

  Image(int64_t count_in, const GraphNetworkWeights<Element>& weights, Arena& arena)
      : count(count_in), rows(PaddedChannels<Element>(count_in)), stride(rows * kernels::kBlock) {
    const int64_t floats = kernels::BlocksOf(weights.size) * stride;
    const int64_t elements =
        weights.heads * weights.head_size / kernels::kChannelsPer<Element> * rows;
    tokens = arena.Allocate<float>({floats}).data();
    if constexpr (std::is_same_v<Element, float>) {
      operands = tokens;
    } else {
      const int64_t operand_elements = kernels::ElementBlocks<Element>(weights.size) * stride;
      operands = arena.Allocate<Element>({operand_elements}).data();
      std::fill_n(operands, operand_elements, Element{});
    }
    projected = arena.Allocate<float>({floats}).data();
    q = arena.Allocate<Element>({elements}).data();
    for (std::size_t set = 0; set < k.size(); ++set) {
      k[set] = arena.Allocate<Element>({elements}).data();
      v[set] = arena.Allocate<Element>({elements}).data();
      std::fill_n(v[set], elements, Element{});
    }
  }

  int64_t count;
  int64_t rows;    ///< Whole blocks of elements, for values are the elements of a right operand.
  int64_t stride;  ///< Elements from a block to the next.
  float* tokens;
  Element* operands;  ///< The tokens as left operand.
  float* projected;   ///< Of image 1, packed.
  Element* q;
  /// Layers in turn.
  std::array<Element*, kKeySets> k;
  std::array<Element*, kKeySets> v;
};

/// Of one thread, for one band.
template <typename Element>
struct GraphNetwork<Element>::Scratch {
  float* scores;
  Element* attended;  ///< Also keys and values on their way to their places.
  Element* hidden;
  std::array<float*, 2> encoder;
};

/// What the threads of one run share.
template <typename Element>
struct GraphNetwork<Element>::Shared {
  Shared(const Features& features0, const Features& features1,
         const GraphNetworkWeights<Element>& weights, int64_t steps, Workspace& workspace)
      : features{&features0, &features1},
        bands({features0.size(), features1.size()}, workspace.pool.size()),
        images{Image(features0.size(), weights, workspace.arena),
               Image(features1.size(), weights, workspace.arena)},
        progress(workspace.arena.Allocate<int32_t>({2 * steps}).data(),
                 workspace.arena.Allocate<int32_t>({bands.size()}).data(), bands.counts(), steps) {
    constexpr int64_t kChannels = kernels::kChannelsPer<Element>;
    Arena& arena = workspace.arena;
    const int64_t threads = workspace.pool.size();
    const int64_t most = std::max(images[0].count, images[1].count);
    const int64_t rows = bands.most_rows();
    scores = arena.Allocate<float>({threads, kernels::AttentionScratchFloats(most)});
    attended =
        arena.Allocate<Element>({threads, weights.heads * weights.head_size / kChannels * rows});
    hidden = arena.Allocate<Element>({threads, weights.hidden_size / kChannels * rows});
    encoder = arena.Allocate<float>(
        {threads, 2, std::max<int64_t>(weights.widest, kernels::kBlock) * rows});
  }

  Scratch ScratchOf(int worker) const {
    float* const encoder_of_worker = encoder.data() + worker * 2 * encoder.extent(2);
    return {scores.data() + worker * scores.extent(1),
            attended.data() + worker * attended.extent(1),
            hidden.data() + worker * hidden.extent(1),
            {encoder_of_worker, encoder_of_worker + encoder.extent(2)}};
  }

  std::array<const Features*, 2> features;
  Bands bands;
  std::array<Image, 2> images;
  StepProgress progress;
  /// Of each thread.
  TensorView<float> scores;
  TensorView<Element> attended;
  TensorView<Element> hidden;
  TensorView<float> encoder;
};

}  // namespace gluevo::nn
