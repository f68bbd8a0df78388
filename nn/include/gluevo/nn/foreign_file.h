#pragma once

#include <optional>
#include <string>
#include <string_view>

#include "gluevo/nn/bytes.h"

namespace gluevo::nn {

/// What a file is that users have in place of weights: a page or an error message that was saved
/// when it should have been downloaded, a pointer of Git LFS or git-annex, an archive that weights
/// are packed into, an image. In words that follow "the file is", with what to do about it or with
/// the forms that are expected. Nothing for all other files, weights among them.
std::optional<std::string> ForeignForm(const Bytes& file, std::string_view expected);

}  // namespace gluevo::nn
