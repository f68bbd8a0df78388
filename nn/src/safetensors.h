#pragma once

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/weights.h"

namespace gluevo::nn {

/// Fills metadata and tensors from a safetensors file: eight bytes of header length, a JSON header,
/// the data (https://huggingface.co/docs/safetensors). As strict as the format's own reader, and
/// stricter: data must be covered without gap or overlap, names come once, values are finite.
void ParseSafetensors(const Bytes& file, Weights& weights);

/// True where the file can be nothing else: a length below 4 GB and then the brace of the header.
bool LooksLikeSafetensors(const Bytes& file);

}  // namespace gluevo::nn
