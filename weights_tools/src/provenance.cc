#include "provenance.h"

namespace gluevo::weights_tools {

std::map<std::string, std::string> UsualProvenance(const std::string& dialect,
                                                   const std::string& network) {
  if (network == "aliked") {
    return {{"licence",
             "not stated in the file; Shiaoming/ALIKED publishes such weights under BSD-3-Clause"},
            {"descriptors",
             "fit a LightGlue trained on them; those of 64 values fit none that is "
             "published"}};
  }
  if (network == "lightglue") {
    return {{"licence",
             "not stated in the file; cvg/LightGlue publishes such weights under Apache-2.0"},
            {"descriptors",
             "of the network it was trained on, which its file's name tells: "
             "ALIKED, DISK or SuperPoint"}};
  }
  const bool superpoint = network == "superpoint";
  if (dialect == "rpautrat") {
    return {
        {"licence", "not stated in the file; rpautrat/SuperPoint publishes such weights under MIT"},
        {"descriptors", "fit a SuperGlue trained on them, not the one that Magic Leap published"}};
  }
  if (dialect == "pytorch-superpoint") {
    return {
        {"licence",
         "not stated in the file; eric-yyjau/pytorch-superpoint publishes such weights under "
         "MIT"},
        {"descriptors", "fit a SuperGlue trained on them, not the one that Magic Leap published"}};
  }
  return {{"licence",
           "not stated in the file; weights that Magic Leap published are for academic and "
           "non-commercial use and may not be passed on"},
          {"descriptors", superpoint ? "fit a SuperGlue trained on them: Magic Leap's SuperPoint "
                                       "fits Magic Leap's SuperGlue, indoor and outdoor"
                                     : "of the SuperPoint it was trained on: Magic Leap's "
                                       "SuperGlue, indoor and outdoor, fits Magic Leap's "
                                       "SuperPoint"}};
}

}  // namespace gluevo::weights_tools
