#pragma once

#include <filesystem>
#include <functional>
#include <string>

#include "gluevo/nn/lightglue.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/workspace.h"
#include "gluevo/vo/pipeline/networks.h"

namespace gluevo::apps {

/// What `gluevo bench` gives the networks.
struct BenchInputs {
  int width = 752;                 ///< Pixels; of the image, or of the images the features are of.
  int height = 480;                ///< Pixels.
  int keypoints = 500;             ///< At most so many are found, or this number is matched.
  std::filesystem::path image;     ///< Empty: noise of the size above.
  std::filesystem::path features;  ///< Empty: random ones; as ReadFeaturePair takes them.
};

/// A network with its inputs, ready to run again and again. Refers to the workspace it was made
/// with.
struct BenchWork {
  std::string size;    ///< "752x480", pixels, of the image or of the one that features0 are of.
  int keypoints = 0;   ///< At most so many are found, or those of features0.
  int layers = 0;      ///< Of a matcher, those that run; 0 of the others.
  double flops = 0.0;  ///< Floating-point operations of one call, as published.
  /// One call: from the image to keypoints and descriptors, or from two sets of them to matches.
  std::function<void()> run;
  /// The inputs and all that the network computes from them, by the names and in the shapes of the
  /// files that tests/golden/README.md lists. Keypoints come in order of falling score.
  std::function<nn::Weights()> outputs;
};

/// Of the one network that was loaded. SuperPoint with its usual threshold of scores, ALIKED with
/// none, so that the best keypoints are found however small the scores are.
BenchWork MakeSuperPointWork(const vo::Networks& networks, const BenchInputs& inputs,
                             nn::Workspace& workspace);
BenchWork MakeAlikedWork(const vo::Networks& networks, const BenchInputs& inputs,
                         nn::Workspace& workspace);
BenchWork MakeSuperGlueWork(const vo::Networks& networks, const BenchInputs& inputs,
                            nn::Workspace& workspace);
BenchWork MakeLightGlueWork(const vo::Networks& networks, const nn::LightGlueOptions& options,
                            const BenchInputs& inputs, nn::Workspace& workspace);

/// Features of two images from a .safetensors or .npz file with keypoints0 [N x 2] (pixels),
/// scores0 [N], descriptors0 [N x D], size0 [2] (width, height of the image) and the same of image
/// 1; other tensors are ignored. Throws Error naming the file and the tensor that does not fit.
struct FeaturePair {
  nn::Features features0;
  nn::Features features1;
};
FeaturePair ReadFeaturePair(const std::filesystem::path& path);

}  // namespace gluevo::apps
