#include "containers.h"

namespace gluevo::weights_tools {

nn::Weights ReadContainer(const std::filesystem::path& path) { return nn::ReadWeights(path); }

}  // namespace gluevo::weights_tools
