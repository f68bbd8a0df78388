#include "partial_directory.h"

#include <gtest/gtest.h>

#include <fstream>
#include <string>

#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::simulation {
namespace {

namespace fs = std::filesystem;

std::string ErrorOf(const fs::path& directory) {
  try {
    const PartialDirectory partial(directory, "content");
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

TEST(PartialDirectoryTest, TakesItsNameWhenWholeAndVanishesOtherwise) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "a" / "out";
  {
    const PartialDirectory partial(out / "", "content");
    partial.Sub("content/sub");
    EXPECT_TRUE(fs::exists(out.string() + ".part/content/sub"));
  }
  EXPECT_TRUE(fs::is_empty(folder.path() / "a"));
  {
    PartialDirectory partial(out, "content");
    partial.Sub("content/sub");
    partial.Finish();
  }
  EXPECT_TRUE(fs::exists(out / "content" / "sub"));
  EXPECT_FALSE(fs::exists(out.string() + ".part"));
  EXPECT_EQ(ErrorOf(out), out.string() + ": exists already, expected the name of a new folder");
}

TEST(PartialDirectoryTest, ReplacesOnlyWhatADeadProgramLeft) {
  const TemporaryFolder folder;
  const fs::path out = folder.path() / "out";
  const fs::path part = folder.path() / "out.part";
  fs::create_directories(part / "content" / "old");
  {
    const PartialDirectory partial(out, "content");
    EXPECT_FALSE(fs::exists(part / "content"));
    partial.Sub("content");
    // Locks belong to the opened folder, so that this stands for another program.
    EXPECT_EQ(ErrorOf(out), part.string() + ": is being filled by another program");
    EXPECT_TRUE(fs::exists(part / "content"));
  }
  fs::create_directories(part / "holiday pictures");
  EXPECT_EQ(ErrorOf(out), part.string() + ": is in the way, and not what an earlier run left");
  EXPECT_TRUE(fs::exists(part / "holiday pictures"));
  fs::remove_all(part);
  std::ofstream(part) << "text";
  EXPECT_NE(ErrorOf(out), "");
  EXPECT_TRUE(fs::is_regular_file(part));
}

}  // namespace
}  // namespace gluevo::simulation
