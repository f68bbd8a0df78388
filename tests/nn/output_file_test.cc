#include "gluevo/nn/output_file.h"

#include <fcntl.h>
#include <gtest/gtest.h>
#include <sys/file.h>
#include <unistd.h>

#include <fstream>
#include <iterator>
#include <string>

#include "file_size_limit.h"
#include "gluevo/nn/error.h"
#include "temporary_folder.h"

namespace gluevo::nn {
namespace {

namespace fs = std::filesystem;

class OutputFileTest : public ::testing::Test {
 protected:
  fs::path Path(const std::string& name) const { return folder_.path() / name; }
  static std::string Contents(const fs::path& path) {
    std::ifstream stream(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(stream), {}};
  }
  void Put(const std::string& name, const std::string& text) const {
    std::ofstream(Path(name)) << text;
  }
  std::size_t Files() const {
    return static_cast<std::size_t>(std::distance(fs::directory_iterator(folder_.path()), {}));
  }

 private:
  TemporaryFolder folder_;
};

TEST_F(OutputFileTest, IsWholeOrNotThere) {
  Put("file", "old");
  EXPECT_THROW(WriteWholeFile(Path("file"),
                              [](std::ostream& out) {
                                out << "half";
                                throw Error("no more");
                              }),
               Error);
  EXPECT_EQ(Contents(Path("file")), "old");
  const std::string longer_than_a_buffer(200'000, 'x');
  WriteWholeFile(Path("file"), [&](std::ostream& out) {
    out << 1.5 << ' ';
    EXPECT_EQ(Contents(Path("file")), "old");
    out << longer_than_a_buffer << '\n';
  });
  EXPECT_EQ(Contents(Path("file")), "1.5 " + longer_than_a_buffer + "\n");
  EXPECT_EQ(Files(), 1U);
}

TEST_F(OutputFileTest, AFullDiskLeavesTheOldFileAndSaysSo) {
  Put("file", "old");
  const FileSizeLimit limit(100'000);
  for (const auto& write : {WriteWholeFile, WriteFileInPlace}) {
    const std::string name = write == WriteWholeFile ? "file" : "in_place";
    try {
      write(Path(name), [](std::ostream& out) {
        for (int i = 0; i < 100'000; ++i) out << "number " << i << '\n';
      });
      FAIL();
    } catch (const Error& error) {
      EXPECT_EQ(error.what(), Path(name).string() + ": cannot be written: File too large");
    }
  }
  EXPECT_EQ(Contents(Path("file")), "old");
  EXPECT_EQ(Files(), 2U);
}

TEST_F(OutputFileTest, RemovesWhatADeadProgramLeftAndNothingElse) {
  for (const char* const name :
       {"file.unfinished-1", "file.unfinished-999999999", "file.unfinished-", "file.unfinished-1x",
        "other.unfinished-1", "file.unfinished-2"}) {
    Put(name, "kept?");
  }
  // This process's own number, as another program had it before.
  Put("file.unfinished-" + std::to_string(getpid()), "old");
  // One that is being filled: a lock belongs to the opened file, so that this stands for another
  // program.
  const int running = open(Path("file.unfinished-2").c_str(), O_RDWR);
  ASSERT_EQ(flock(running, LOCK_EX), 0);
  WriteWholeFile(Path("file"), [](std::ostream& out) { out << "new"; });
  EXPECT_EQ(Contents(Path("file")), "new");
  for (const char* const name :
       {"file.unfinished-", "file.unfinished-1x", "other.unfinished-1", "file.unfinished-2"}) {
    EXPECT_TRUE(fs::exists(Path(name))) << name;
  }
  EXPECT_EQ(Files(), 5U);
  close(running);
  WriteWholeFile(Path("file"), [](std::ostream& out) { out << "newer"; });
  EXPECT_FALSE(fs::exists(Path("file.unfinished-2")));
}

TEST_F(OutputFileTest, AFileThatIsBeingFilledIsLocked) {
  UnfinishedFile file(Path("file"));
  const int other = open(file.beside().c_str(), O_RDWR);
  EXPECT_NE(flock(other, LOCK_EX | LOCK_NB), 0);
  close(other);
  CheckPlaceForFile(Path("another"));
  EXPECT_TRUE(fs::exists(file.beside()));
  file.Finish();
  EXPECT_TRUE(fs::exists(Path("file")));
  EXPECT_EQ(Files(), 1U);
}

TEST_F(OutputFileTest, PlacesThatTakeNoFileAreRefusedAtOnce) {
  for (const fs::path& place : {Path(""), Path("none/file"), fs::path("/dev/full")}) {
    EXPECT_THROW(CheckPlaceForFile(place), Error) << place;
  }
  EXPECT_EQ(Files(), 0U);
}

TEST_F(OutputFileTest, ALinkStaysALink) {
  Put("target", "old");
  fs::create_symlink("target", Path("link"));
  WriteWholeFile(Path("link"), [](std::ostream& out) { out << "new"; });
  EXPECT_TRUE(fs::is_symlink(Path("link")));
  EXPECT_EQ(Contents(Path("target")), "new");
}

}  // namespace
}  // namespace gluevo::nn
