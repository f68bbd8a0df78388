#include "superpoint_layers.h"

#include "kernels/winograd.h"

namespace gluevo::nn {

using kernels::BlockedMap;
using kernels::BlocksOf;
using kernels::kBlock;

SuperPoint::Convolution::Convolution(const Weights& file, const std::string& name,
                                     int64_t kernel_size, int64_t in_channels_in,
                                     const kernels::Kernels& kernels)
    : in_channels(in_channels_in) {
  const Tensor<float>& weight = file.Get(name + ".weight");
  out_channels = weight.shape().rank() == 4 ? weight.extent(0) : 0;
  CheckShape(weight.shape(), {out_channels, in_channels, kernel_size, kernel_size},
             file.source + ": " + name + ".weight");
  const auto read_padded = [&](const std::string& part) {
    const Tensor<float>& values = file.Get(name + part, Shape{out_channels});
    Tensor<float> padded({BlocksOf(out_channels) * kBlock});
    std::copy_n(values.data(), values.size(), padded.data());
    return padded;
  };
  bias = read_padded(".bias");
  if (file.Has(name + ".scale")) {
    scale = read_padded(".scale");
    shift = read_padded(".shift");
  }

  if (kernel_size == 1) {
    weights = Tensor<float>({kernels::PackedMatrixSize<float>(out_channels, in_channels)});
    kernels::PackMatrix(weight.data(), in_channels, out_channels, in_channels, weights.data());
  } else if (in_channels > 1 && kernels.winograd3x3 != nullptr) {
    kernel = kernels.winograd3x3;
    weights = Tensor<float>({kernels::PackedWinograd3x3Floats(out_channels, in_channels)});
    kernels::PackWinograd3x3(weight.data(), out_channels, in_channels, weights.data());
  } else {
    kernel = kernels.conv3x3;
    weights = Tensor<float>({kernels::PackedConv3x3Floats(out_channels, in_channels)});
    kernels::PackConv3x3(weight.data(), out_channels, in_channels, weights.data());
  }
}

BlockedMap SuperPoint::Buffers::Output(const BlockedMap& in, int64_t channels, int64_t height,
                                       int64_t width) const {
  const int64_t buffer = in.data == maps.data() ? 1 : 0;
  const BlockedMap map{maps.data() + buffer * maps.extent(1), BlocksOf(channels), height, width};
  kernels::ClearHalo(map);
  return map;
}

kernels::Conv3x3 SuperPoint::Convolution::Of(const BlockedMap& in, const BlockedMap& out,
                                             const Buffers& buffers, int worker) const {
  return {.in = in,
          .weights = weights.data(),
          .bias = bias.data(),
          .relu = true,
          .scale = scale.data(),
          .shift = shift.data(),
          .pool = pool,
          .out = out,
          .row_end = in.height,
          .column_end = in.width,
          .scratch = buffers.scratch.data() + worker * buffers.scratch.extent(1)};
}

void SuperPoint::Convolve(const Convolution& layer, const BlockedMap& in, const BlockedMap& out,
                          Workspace& workspace, const Buffers& buffers) const {
  ForRegions(workspace.pool, in.height, in.width,
             [&](int64_t row_begin, int64_t row_end, int64_t column_begin, int64_t column_end,
                 int worker) {
               kernels::Conv3x3 region = layer.Of(in, out, buffers, worker);
               region.row_begin = row_begin;
               region.row_end = row_end;
               region.column_begin = column_begin;
               region.column_end = column_end;
               layer.kernel(region);
             });
}

namespace {

// The image as floats 0 to 1 with a halo of zeros: [height + 2][width + 2].
float* GrayPlane(const GrayImage& image, Workspace& workspace) {
  const int64_t stride = image.width + 2;
  const TensorView<float> plane = workspace.arena.Allocate<float>({image.height + 2, stride});
  plane.Matrix().row(0).setZero();
  plane.Matrix().row(image.height + 1).setZero();
  workspace.pool.ParallelFor((image.height + 63) / 64, [&](int64_t band, int /*worker*/) {
    for (int64_t y = band * 64; y < std::min<int64_t>(image.height, (band + 1) * 64); ++y) {
      float* const to = plane.data() + (y + 1) * stride;
      const uint8_t* const from = image.data + y * image.stride;
      to[0] = 0.0F;
      for (int64_t x = 0; x < image.width; ++x) {
        to[x + 1] = static_cast<float>(from[x]) / 255.0F;
      }
      to[image.width + 1] = 0.0F;
    }
  });
  return plane.data();
}

}  // namespace

// The first layer's output is the largest of all and costs little: each thread computes what one
// region of the second layer needs of it, and drops it.
BlockedMap SuperPoint::FirstLayers(const GrayImage& image, Workspace& workspace,
                                   const Buffers& buffers) const {
  const Convolution& first = layers_->trunk[0];
  const Convolution& second = layers_->trunk[1];
  float* const gray = GrayPlane(image, workspace);
  const int64_t width = image.width;
  const int64_t height = image.height;
  const int64_t first_blocks = BlocksOf(first.out_channels);
  const TensorView<float> regions = workspace.arena.Allocate<float>(
      {workspace.pool.size(), BlockedMap::Floats(first_blocks, 8, 56)});
  const BlockedMap map = buffers.Output({}, second.out_channels, height / 2, width / 2);
  ForRegions(
      workspace.pool, height, width,
      [&](int64_t row, int64_t row_end, int64_t column, int64_t column_end, int worker) {
        // Its halo holds the neighbours, or the zeros around the image.
        const BlockedMap region{regions.data() + worker * regions.extent(1), first_blocks,
                                row_end - row, column_end - column};
        const bool left = column == 0;
        const bool right = column_end == width;
        const bool top = row == 0;
        const bool bottom = row_end == height;
        if (left || right || top || bottom) {
          kernels::ClearHalo(region);
        }
        first.kernel({.in = {gray + row * (width + 2) + column, 1, height, width},
                      .gray = true,
                      .weights = first.weights.data(),
                      .bias = first.bias.data(),
                      .relu = true,
                      .scale = first.scale.data(),
                      .shift = first.shift.data(),
                      .out = region,
                      .row_begin = top ? 0 : -1,
                      .row_end = region.height + (bottom ? 0 : 1),
                      .column_begin = left ? 0 : -1,
                      .column_end = region.width + (right ? 0 : 1)});
        BlockedMap out = map;
        out.data += row / 2 * map.row_stride() + column / 2 * kBlock;
        second.kernel({.in = region,
                       .weights = second.weights.data(),
                       .bias = second.bias.data(),
                       .relu = true,
                       .scale = second.scale.data(),
                       .shift = second.shift.data(),
                       .pool = true,
                       .out = out,
                       .row_begin = 0,
                       .row_end = region.height,
                       .column_begin = 0,
                       .column_end = region.width,
                       .scratch = buffers.scratch.data() + worker * buffers.scratch.extent(1)});
      });
  return map;
}

BlockedMap SuperPoint::Trunk(const GrayImage& image, Heads heads, Workspace& workspace,
                             Buffers& buffers) const {
  if (image.width < 8 || image.height < 8) {
    throw Error("an image of " + std::to_string(image.width) + " x " +
                std::to_string(image.height) + " pixels: SuperPoint needs at least 8 x 8");
  }
  Arena& arena = workspace.arena;
  arena.Reset();
  int64_t height = image.height;
  int64_t width = image.width;
  int64_t largest_map = 0;
  int64_t largest_scratch = 0;
  const auto add_layer = [&](const Convolution& layer) {
    height = layer.pool ? height / 2 : height;
    width = layer.pool ? width / 2 : width;
    largest_map =
        std::max(largest_map, BlockedMap::Floats(BlocksOf(layer.out_channels), height, width));
    largest_scratch = std::max(largest_scratch, kernels::WinogradScratchFloats(layer.in_channels));
  };
  const std::vector<Convolution>& trunk = layers_->trunk;
  std::for_each(trunk.begin() + 1, trunk.end(), add_layer);
  add_layer(layers_->descriptor.hidden);
  if (heads == Heads::kBoth) {
    add_layer(layers_->detector.hidden);
  }
  buffers.maps = arena.Allocate<float>({2, (largest_map + kBlock - 1) / kBlock * kBlock});
  buffers.scratch = arena.Allocate<float>({workspace.pool.size(), largest_scratch});

  BlockedMap map = FirstLayers(image, workspace, buffers);
  for (std::size_t i = 2; i < trunk.size(); ++i) {
    const Convolution& layer = trunk[i];
    const BlockedMap out =
        buffers.Output(map, layer.out_channels, layer.pool ? map.height / 2 : map.height,
                       layer.pool ? map.width / 2 : map.width);
    Convolve(layer, map, out, workspace, buffers);
    map = out;
  }
  return map;
}

}  // namespace gluevo::nn
