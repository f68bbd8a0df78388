#pragma once

#include <cstddef>
#include <functional>
#include <optional>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/elements.h"
#include "gluevo/nn/weights.h"
#include "pickle.h"

namespace gluevo::weights_tools {

/// The dictionary of tensors in what torch.save was given: the dictionary itself, or the one under
/// "state_dict", "model_state_dict", "model", "net", ... of a training checkpoint. Throws Error,
/// naming the keys that are there, where there is none.
const PickleObject& FindStateDict(const Pickle& pickle, const nn::Bytes& bytes);

/// Size in bytes of an element of this storage.
std::size_t StorageElementSize(const Pickle& pickle, const PickleObject& storage);

/// Fills tensors with those of the dictionary; `bytes_of` gives the bytes of a storage. Values that
/// are no tensors are left out, and so are the integer counters of batch norms. Throws Error for
/// names that come twice, integer tensors, and tensors beyond their storage.
void ReadStateDict(const Pickle& pickle, const nn::Bytes& bytes,
                   const std::function<nn::Bytes(const PickleObject& storage)>& bytes_of,
                   uint64_t file_size, nn::Weights& weights);

}  // namespace gluevo::weights_tools
