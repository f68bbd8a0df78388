#pragma once

#include <vector>

#include "gluevo/nn/bytes.h"
#include "gluevo/nn/weights.h"
#include "gluevo/nn/zip.h"

namespace gluevo::weights_tools {

/// True for an archive as torch.save writes it since PyTorch 1.6 (or torch.jit.save).
bool IsTorchArchive(const std::vector<nn::ZipEntry>& entries);

/// Fills tensors from such an archive: PREFIX/data.pkl, a pickled dictionary of tensors (see
/// FindStateDict), and PREFIX/data/KEY, their storages. Throws Error with the offset for anything
/// that is not exactly that, big-endian storages and TorchScript among it.
void ParseTorchArchive(const nn::Bytes& file, const std::vector<nn::ZipEntry>& entries,
                       nn::Weights& weights);

/// True for a file that begins as torch.save wrote it before PyTorch 1.6: with a pickle.
bool LooksLikeTorchLegacy(const nn::Bytes& file);

/// The same from such a file: pickles of a magic number, a version, the byte order, the dictionary
/// and the list of storage keys, then the storages in the list's order, each after the number of
/// its elements.
void ParseTorchLegacy(const nn::Bytes& file, nn::Weights& weights);

}  // namespace gluevo::weights_tools
