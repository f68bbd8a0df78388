#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <limits>

#include "zip_files.h"

namespace gluevo::nn {
namespace {

TEST(NpzTest, ChecksumOfTheseTestsIsTheStandardOne) {
  EXPECT_EQ(Crc("123456789"), 0xcbf43926U);  // The check value of CRC-32/ISO-HDLC.
}

std::string Npy(const std::string& dictionary, const std::string& data, char major = 1) {
  const std::string length = major == 1 ? Le(static_cast<uint16_t>(dictionary.size()))
                                        : Le(static_cast<uint32_t>(dictionary.size()));
  return std::string("\x93NUMPY") + major + '\0' + length + dictionary + data;
}

std::string Dictionary(const std::string& descr, const std::string& shape,
                       const std::string& fortran = "False") {
  return "{'descr': '" + descr + "', 'fortran_order': " + fortran + ", 'shape': " + shape + ", }\n";
}

// A local header of 30 bytes and the name "w.npy" lie before the data of the first entry.
constexpr uint64_t kData = 35;
// Magic, version and a length of two bytes lie before the dictionary.
constexpr uint64_t kDictionary = kData + 10;
// "{'descr': '<f4', 'fortran_order': False, 'shape': " lies before the shape.
constexpr uint64_t kShape = kDictionary + 50;

std::string Good() { return Npy(Dictionary("<f4", "(2, 2)"), Floats({1, 2, 3, 4})); }
std::string Stored(const std::string& npy) { return Archive{{Entry("w.npy", npy)}}.Bytes(); }
std::string OfDictionary(const std::string& dictionary) { return Stored(Npy(dictionary, "")); }

TEST(NpzTest, ReadsStoredAndDeflatedArrays) {
  const std::string scalar = Npy(Dictionary("<f4", "()"), Floats({-0.5F}));
  const Weights weights =
      Parse(Archive{{Entry("conv.weight.npy", Good()),
                     Entry::Deflated("bin_score.npy", scalar, StoredBlock(scalar))}}
                .Bytes());
  ASSERT_EQ(weights.tensors.size(), 2U);
  EXPECT_TRUE(weights.metadata.empty());
  EXPECT_EQ(Values(weights.Get("conv.weight", Shape{2, 2})), (std::vector<float>{1, 2, 3, 4}));
  EXPECT_EQ(Values(weights.Get("bin_score", Shape{})), (std::vector<float>{-0.5F}));
}

TEST(NpzTest, ReadsAnArchiveOfNothing) { EXPECT_TRUE(Parse(Archive{{}}.Bytes()).tensors.empty()); }

TEST(NpzTest, ReadsWhatZipWritersVary) {
  Entry entry("w.npy", Good());
  entry.zip64_mark = true;  // As numpy does.
  entry.extra = std::string(20, 'x');
  Archive archive{{entry}};
  archive.comment = "PK\5\6 a comment";
  EXPECT_TRUE(Parse(archive.Bytes()).Has("w"));

  Entry streamed("w.npy", Good());
  streamed.flags = 8;
  streamed.after = "PK\7\x8" + Le(streamed.crc) + Le(streamed.packed_size) + Le(streamed.size);
  EXPECT_TRUE(Parse(Archive{{streamed, Entry("v.npy", Good())}}.Bytes()).Has("w"));
}

TEST(NpzTest, ReadsEveryFormatVersionAndDictionaryForm) {
  for (const char major : {1, 2, 3}) {
    EXPECT_TRUE(Parse(Stored(Npy(Dictionary("<f4", "(1,)"), Floats({1}), major))).Has("w"));
  }
  const std::string form = "{\"shape\":(1,1 , 1,),\"descr\":\"<f4\",\"fortran_order\":True}   \n";
  EXPECT_EQ(Parse(Stored(Npy(form, Floats({1})))).Get("w").shape(), (Shape{1, 1, 1}));
}

TEST(NpzTest, WidensHalfAndNarrowsDouble) {
  const std::string half =
      Npy(Dictionary("<f2", "(2,)"), Le<uint16_t>(0x3e00) + Le<uint16_t>(0x8001));
  EXPECT_EQ(Values(Parse(Stored(half)).Get("w")),
            (std::vector<float>{1.5F, -std::ldexp(1.0F, -24)}));
  // 0.1 rounds to the nearest float; 1e-50 underflows to zero.
  const std::string wide = Npy(Dictionary("<f8", "(2,)"), Le(std::bit_cast<uint64_t>(0.1)) +
                                                              Le(std::bit_cast<uint64_t>(1e-50)));
  EXPECT_EQ(Values(Parse(Stored(wide)).Get("w")), (std::vector<float>{0.1F, 0.0F}));
}

TEST(NpzTest, ReadsBfloat16AsItsExtensionOfNumpySavesIt) {
  const std::string npy =
      Npy(Dictionary("<V2", "(2,)"), Le<uint16_t>(0x3fc0) + Le<uint16_t>(0xc000));
  EXPECT_EQ(Values(Parse(Stored(npy)).Get("w")), (std::vector<float>{1.5F, -2.0F}));
}

TEST(NpzTest, TransposesFortranOrder) {
  // Element (i, j, k) of a 2 x 3 x 2 array is 100 i + 10 j + k; the first index runs fastest.
  std::vector<float> stored;
  for (int k = 0; k < 2; ++k) {
    for (int j = 0; j < 3; ++j) {
      for (int i = 0; i < 2; ++i) {
        stored.push_back(static_cast<float>(100 * i + 10 * j + k));
      }
    }
  }
  const Weights weights =
      Parse(Stored(Npy(Dictionary("<f4", "(2, 3, 2)", "True"), Floats(stored))));
  EXPECT_EQ(Values(weights.Get("w", Shape{2, 3, 2})),
            (std::vector<float>{0, 1, 10, 11, 20, 21, 100, 101, 110, 111, 120, 121}));
}

TEST(NpzTest, RefusesNanInfinityAndDoublesBeyondFloat) {
  const std::string dictionary = Dictionary("<f4", "(2,)");
  const uint64_t data = kDictionary + dictionary.size();
  ExpectRefused(Stored(Npy(dictionary, Floats({1, NAN}))), data + 4, "tensor \"w\" holds NaN");
  ExpectRefused(Stored(Npy(dictionary, Floats({INFINITY, 1}))), data, "holds an infinite value");
  const std::string wide = Npy(Dictionary("<f8", "(1,)"), Le(std::bit_cast<uint64_t>(1e39)));
  ExpectRefused(Stored(wide), data, "holds an infinite value");
}

TEST(NpzTest, OffsetsInDeflatedEntriesNameBothPlaces) {
  const std::string dictionary = Dictionary("<f4", "(2,)");
  const std::string npy = Npy(dictionary, Floats({1, NAN}));
  ExpectRefused(Archive{{Entry::Deflated("w.npy", npy, StoredBlock(npy))}}.Bytes(),
                "35 (inflated byte " + std::to_string(10 + dictionary.size() + 4) + ")",
                "holds NaN");
}

TEST(NpzTest, RefusesOtherElementTypes) {
  ExpectRefused(OfDictionary(Dictionary(">f4", "(1,)")), kDictionary, "\">f4\" (big-endian)");
  for (const char* type : {"<i8", "|u1", "<f16", "<c8", "f4", "|O", "|V2", ""}) {
    ExpectRefused(OfDictionary(Dictionary(type, "(1,)")), kDictionary,
                  "has element type \"" + std::string(type) + "\", expected '<f4'");
  }
  ExpectRefused(OfDictionary("{'descr': [('a', '<f4')], 'fortran_order': False, 'shape': ()}"),
                kDictionary + 10, "no string here, expected an element type");
}

TEST(NpzTest, RefusesDictionariesOfAnotherForm) {
  const std::string rest = "'fortran_order': False, 'shape': (1,)}";
  const std::string descr = "{'descr': '<f4', ";
  ExpectRefused(OfDictionary(""), kDictionary, "no '{' here");
  ExpectRefused(OfDictionary("{"), kDictionary + 1, "no string here, expected a key");
  ExpectRefused(OfDictionary("{}"), kDictionary, "no key \"descr\"");
  ExpectRefused(OfDictionary(descr + "'shape': ()}"), kDictionary, "no key \"fortran_order\"");
  ExpectRefused(OfDictionary(descr + "'fortran_order': True}"), kDictionary, "no key \"shape\"");
  ExpectRefused(OfDictionary(descr + "'descr': '<f4', " + rest), kDictionary + 17,
                "the key \"descr\" comes twice");
  ExpectRefused(OfDictionary(descr + "'colour': 1}"), kDictionary + 17, "an unknown key");
  ExpectRefused(OfDictionary("{'descr' '<f4'}"), kDictionary + 9, "no ':' here");
  ExpectRefused(OfDictionary("{'de\\x73cr': '<f4'}"), kDictionary + 1, "a broken string");
  ExpectRefused(OfDictionary("{'descr"), kDictionary + 1, "a broken string");
  ExpectRefused(OfDictionary(descr + "'fortran_order': 0}"), kDictionary + 34,
                "neither True nor False");
  ExpectRefused(OfDictionary(descr + rest + "+x"), kDictionary + 17 + rest.size(),
                "text after the dictionary");
  ExpectRefused(OfDictionary(Dictionary("<f4", "3")), kShape, "no '(' here");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(3)")), kShape + 2, "no ',' here");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(3 4)")), kShape + 3, "no ',' here");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(-3,)")), kShape + 1, "no number here");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(,)")), kShape + 1, "no number here");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(3")), kShape + 4, "no number here");
}

TEST(NpzTest, RefusesShapesThatOverflowOrHaveTooManyAxes) {
  ExpectRefused(OfDictionary(Dictionary("<f4", "(99999999999999999999,)")), kShape + 1,
                "an extent that overflows");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(4294967296, 4294967296)")), kDictionary,
                "overflow");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(0, 11, 777777777777777777, 3)")), kDictionary,
                "overflow");
  ExpectRefused(OfDictionary(Dictionary("<f4", "(1, 1, 1, 1, 1)")), kDictionary, "rank 5");
}

TEST(NpzTest, RefusesArraysOfAnotherSize) {
  const std::string dictionary = Dictionary("<f4", "(2,)");
  const uint64_t data = kDictionary + dictionary.size();
  ExpectRefused(Stored(Npy(dictionary, Floats({1}))), data, "8 bytes expected, 4 are there");
  ExpectRefused(Stored(Npy(dictionary, Floats({1, 2, 3}))), data + 8, "has 4 trailing bytes");
  // A size that no memory has is refused before any is asked for.
  ExpectRefused(Stored(Npy(Dictionary("<f4", "(99999999999,)"), Floats({1}))), data + 10,
                "399999999996 bytes expected, 4 are there");
}

TEST(NpzTest, RefusesWhatIsNoNpy) {
  ExpectRefused(Stored("not numpy"), kData, "does not begin as a .npy file");
  ExpectRefused(Stored("\x93NUM"), kData, "is cut short");
  ExpectRefused(Stored(Npy("", "", 4)), kData + 6, ".npy format 4.0, expected 1.0 to 3.0");
  ExpectRefused(Stored(Npy("", "", 0)), kData + 6, ".npy format 0.0");
  ExpectRefused(Stored(std::string("\x93NUMPY\1\0\xff\0{}", 12)), kDictionary,
                "255 bytes expected, 2 are there");
  ExpectRefused(Archive{{Entry("data.pkl", "x")}}.Bytes(), 0, "\"data.pkl\" of the archive is no");
  ExpectRefused(Archive{{Entry(".npy", "x")}}.Bytes(), 0, "is no .npy array");
  ExpectRefused(Good(), 0, "single .npy array");
  ExpectRefused("GIF89a\x01, certainly no weights", 0, "neither .safetensors nor .npz");
}

TEST(NpzTest, RefusesNamesThatComeTwice) {
  const std::string file = Archive{{Entry("w.npy", Good()), Entry("w.npy", Good())}}.Bytes();
  // The directory is two entries of 46 + 5 bytes before the last record of 22.
  ExpectRefused(file, file.size() - 22 - 51, "the name \"w.npy\" comes twice");
}

TEST(NpzTest, RefusesDamagedData) {
  std::string file = Stored(Good());
  file[kData + Good().size() - 1] ^= 1;
  ExpectRefused(file, kData, "fails its CRC");
}

TEST(NpzTest, RefusesMethodsAndFeaturesThatNumpyDoesNotWrite) {
  const uint64_t directory = kData + Good().size();
  Entry bzip2("w.npy", Good());
  bzip2.method = 12;
  ExpectRefused(Archive{{bzip2}}.Bytes(), directory, "compressed by method 12");
  Entry secret("w.npy", Good());
  secret.flags = 1;
  ExpectRefused(Archive{{secret}}.Bytes(), directory, "is encrypted");
  Entry large("w.npy", Good());
  large.size = 0xffffffff;
  ExpectRefused(Archive{{large}}.Bytes(), directory, "zip64");
  std::string disks = Stored(Good());
  disks[disks.size() - 18] = 1;
  ExpectRefused(disks, disks.size() - 22, "several disks");
}

TEST(NpzTest, RefusesDirectoriesThatContradictTheFile) {
  const std::string good = Stored(Good());
  const uint64_t directory = kData + Good().size();
  const uint64_t end = good.size() - 22;
  ExpectRefused(good + "x", good.size() + 1, "no end record here");
  ExpectRefused(good.substr(0, good.size() - 1), good.size() - 1, "no end record here");
  Archive archive{{Entry("w.npy", Good())}};
  archive.count_off = 1;
  ExpectRefused(archive.Bytes(), end, "entry 1 of the central directory is cut short");
  archive.count_off = -1;
  ExpectRefused(archive.Bytes(), directory, "51 bytes of the central directory belong to no");
  archive.count_off = 0;
  archive.directory_off = 1;
  ExpectRefused(archive.Bytes(), end, "expected it to end here");
  archive.directory_off = 0;
  archive.after_directory = std::string(46, 'x');
  archive.count_off = 1;
  ExpectRefused(archive.Bytes(), directory + 51, "entry 1 of the central directory is not here");
  std::string names = good;
  names[directory + 28] = 6;  // The length of the name.
  ExpectRefused(names, directory, "reaches beyond the directory");
}

TEST(NpzTest, RefusesLocalHeadersThatDiffer) {
  Entry named("w.npy", Good());
  named.local_name = "v.npy";
  ExpectRefused(Archive{{named}}.Bytes(), 0, "names it \"v.npy\"");
  const std::string good = Stored(Good());
  std::string changed = good;
  changed[0] = 'X';
  ExpectRefused("PK" + good, good.size() + 2 - 22, "expected it to end here");
  changed = good;
  changed[2] = 9;
  ExpectRefused(changed, 0, "the local header of \"w.npy\" is not here");
  changed = good;
  changed[8] = 8;
  ExpectRefused(changed, 0, "other flags or another method");
  changed = good;
  changed[14] ^= 1;
  ExpectRefused(changed, 0, "another CRC or size");
  changed = good;
  changed[22] ^= 1;
  ExpectRefused(changed, 0, "another CRC or size");
}

TEST(NpzTest, RefusesEntriesOutOfBoundsOverlapsAndGaps) {
  const uint64_t directory = kData + Good().size();
  Entry far("w.npy", Good());
  far.local_at = 1'000'000;
  ExpectRefused(Archive{{far}}.Bytes(), directory, "is said to be at byte 1000000");
  Entry large("w.npy", Good());
  large.size = large.packed_size = 1'000'000;
  ExpectRefused(Archive{{large}}.Bytes(), 0, "is cut short: 1000000 bytes expected");
  // Reaches into the central directory, which is 51 bytes, but not beyond the file.
  Entry longer("w.npy", Good());
  longer.size += 10;
  longer.packed_size += 10;
  ExpectRefused(Archive{{longer}}.Bytes(), directory, "overlaps the central directory");
  // Another entry inside the data of the first.
  const std::string inner = Stored(Good()).substr(0, directory);
  Entry outer("v.npy", inner);
  Entry inside("w.npy", Good());
  inside.local_at = kData;
  ExpectRefused(Archive{{outer, inside}}.Bytes(), kData, "\"w.npy\" overlaps another");
  Entry gap("w.npy", Good());
  gap.after = "abc";
  ExpectRefused(Archive{{gap, Entry("v.npy", Good())}}.Bytes(), directory,
                "3 bytes before entry \"v.npy\" belong to no entry");
  ExpectRefused(Archive{{gap}}.Bytes(), directory, "3 bytes before the central directory");
  Archive late{{Entry("w.npy", Good())}};
  late.before = "PK";
  ExpectRefused(late.Bytes(), 0, "2 bytes before entry \"w.npy\"");
}

TEST(NpzTest, RefusesDeflateStreamsOfAnotherSize) {
  const std::string good = Good();
  Entry stored("w.npy", good);
  stored.size += 1;
  ExpectRefused(Archive{{stored}}.Bytes(), kData + good.size(), "is stored but its two sizes");
  Entry longer = Entry::Deflated("w.npy", good, StoredBlock(good));
  longer.size -= 1;
  ExpectRefused(Archive{{longer}}.Bytes(), kData + StoredBlock(good).size(),
                "inflates to more than the");
  Entry shorter = Entry::Deflated("w.npy", good, StoredBlock(good));
  shorter.size += 1;
  ExpectRefused(Archive{{shorter}}.Bytes(), kData + StoredBlock(good).size(), "expected");
  const Entry cut = Entry::Deflated("w.npy", good, StoredBlock(good).substr(0, 20));
  ExpectRefused(Archive{{cut}}.Bytes(), kData + 20, "not a whole deflate stream");
  const Entry trailing = Entry::Deflated("w.npy", good, StoredBlock(good) + "ab");
  ExpectRefused(Archive{{trailing}}.Bytes(), kData + StoredBlock(good).size(),
                "2 trailing bytes after its deflate stream");
  // Block type 3 does not exist.
  const Entry broken = Entry::Deflated("w.npy", good, "\7abcdef");
  ExpectRefused(Archive{{broken}}.Bytes(), kData + 1, "not a whole deflate stream");
}

TEST(NpzTest, RefusesBombs) {
  Entry impossible = Entry::Deflated("w.npy", Good(), StoredBlock(Good()));
  impossible.size = 2'000'000'000;
  ExpectRefused(Archive{{impossible}}.Bytes(), 0, "which deflate cannot reach");
  // 80 kB to 80 MB is within deflate's 1032 to 1, but above 64 MiB + 100 times the file's size.
  Entry bomb = Entry::Deflated("w.npy", Good(), std::string(80'000, 'x'));
  bomb.size = 80'000'000;
  ExpectRefused(Archive{{bomb}}.Bytes(), 0, "more than 100 times its size");
}

TEST(NpzTest, LeavesTrainingCountersOut) {
  const std::string counter = Npy(Dictionary("<i8", "()"), Le<uint64_t>(7));
  const Weights weights = Parse(
      Archive{{Entry("bn.num_batches_tracked.npy", counter), Entry("w.npy", Good())}}.Bytes());
  EXPECT_EQ(weights.tensors.size(), 1U);
  EXPECT_TRUE(weights.Has("w"));
}

std::string ReadFile(const std::string& name) {
  std::ifstream stream(std::string(GLUEVO_TEST_DATA_DIR) + "/weights/" + name, std::ios::binary);
  EXPECT_TRUE(stream) << name;
  return {std::istreambuf_iterator<char>(stream), {}};
}

// Written by numpy, see tests/data/weights/README.md for the values.
void ExpectNumpysArrays(const Weights& weights) {
  ASSERT_EQ(weights.tensors.size(), 5U);
  EXPECT_EQ(Values(weights.Get("plain", Shape{2, 3})),
            (std::vector<float>{0, 0.5F, 1, 1.5F, 2, 2.5F}));
  EXPECT_EQ(Values(weights.Get("fortran", Shape{2, 3})), (std::vector<float>{0, 1, 2, 3, 4, 5}));
  EXPECT_EQ(Values(weights.Get("half", Shape{3})),
            (std::vector<float>{1.5F, -2, std::ldexp(1.0F, -24)}));
  EXPECT_EQ(Values(weights.Get("wide", Shape{1})), (std::vector<float>{0.1F}));
  EXPECT_EQ(Values(weights.Get("scalar", Shape{})), (std::vector<float>{-3}));
}

TEST(NpzTest, ReadsNumpysOwnFiles) {
  ExpectNumpysArrays(Parse(ReadFile("numpy.npz")));
  ExpectNumpysArrays(Parse(ReadFile("numpy_compressed.npz")));
}

TEST(NpzTest, EveryTruncationIsRefused) {
  ExpectEveryTruncationRefused(Stored(Good()));
  ExpectEveryTruncationRefused(ReadFile("numpy_compressed.npz"));
}

TEST(NpzTest, ChangedBytesNeverCrash) {
  ExpectFlipsSurvived(Stored(Good()), 10000);
  ExpectFlipsSurvived(ReadFile("numpy.npz"), 5000);
  ExpectFlipsSurvived(ReadFile("numpy_compressed.npz"), 5000);
}

// The CRC hides the arrays from changes in the tests above; here it is made to fit.
TEST(NpzTest, ChangedArraysNeverCrash) {
  std::mt19937 random(7);
  int refused = 0;
  for (int round = 0; round < 10000; ++round) {
    std::string npy = Good();
    npy[random() % npy.size()] = static_cast<char>(random());
    npy[random() % npy.size()] = static_cast<char>(random());
    try {
      Parse(Stored(npy));
    } catch (const Error&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 2500);
}

TEST(NpzTest, RandomDeflateStreamsNeverCrash) {
  std::mt19937 random(11);
  for (int round = 0; round < 10000; ++round) {
    std::string stream(1 + random() % 60, '\0');
    for (char& byte : stream) {
      byte = static_cast<char>(random());
    }
    Entry entry = Entry::Deflated("w.npy", Good(), stream);
    EXPECT_THROW(Parse(Archive{{entry}}.Bytes()), Error);
  }
}

}  // namespace
}  // namespace gluevo::nn
