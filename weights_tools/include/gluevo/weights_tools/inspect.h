#pragma once

#include <string>

#include "gluevo/nn/weights.h"

namespace gluevo::weights_tools {

/// What a weights file is, for people: file, checksum, architecture (or why it is none), source,
/// licence, and a table of the tensors with shapes and ranges of values. Ends with a line feed.
std::string InspectionText(const nn::Weights& weights);

/// The same as a JSON object: "file", "sha256", "architecture" (null where it is none, with
/// "problem" saying why), "source", "licence" and "note" (null where the file does not tell),
/// "metadata", "parameters", and "tensors" as a list of {"name", "shape", "minimum", "maximum"} in
/// the order of names. Ends with a line feed.
std::string InspectionJson(const nn::Weights& weights);

}  // namespace gluevo::weights_tools
