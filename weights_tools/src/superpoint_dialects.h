#pragma once

#include <optional>
#include <string>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// A SuperPoint under the published names, and the dialect that it came in.
struct TranslatedSuperPoint {
  nn::Weights weights;
  std::string dialect;
};

/// Renames the tensors of a SuperPoint. Dialects: "magic-leap", the published names, also with
/// batch norms bn1a, ... between convolution and ReLU; "hugging-face",
/// SuperPointForKeypointDetection of transformers; "rpautrat", the open SuperPoint of
/// rpautrat/SuperPoint (convolution, ReLU, batch norm); "pytorch-superpoint", SuperPointNet_gauss2
/// of eric-yyjau/pytorch-superpoint (convolution, batch norm, ReLU).
///
/// Batch norms before a ReLU, or without one, become part of their convolution. One that follows
/// the ReLU cannot (the next convolution pads with zeros that it does not change) and becomes
/// LAYER.scale and LAYER.shift [channels]: y = relu(convolution) scale + shift. A convolution
/// without a bias gets one of zeros, and a 1x1 convolution may be a matrix.
///
/// `epsilon` is that of all batch norms, where the file tells. Nothing where no dialect knows the
/// names; tensors of no use stay, for the architecture's check to name. Throws Error, naming the
/// tensor, where one lacks or does not fit.
std::optional<TranslatedSuperPoint> TranslateSuperPoint(const nn::Weights& weights,
                                                        std::optional<double> epsilon);

}  // namespace gluevo::weights_tools
