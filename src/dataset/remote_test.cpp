// SPDX-License-Identifier: Apache-2.0
// Tests of names on the network.
#include "dataset/remote.h"

#include <gtest/gtest.h>

namespace terray {
namespace {

TEST(Remote, UrlsHaveGdalsNames) {
    EXPECT_EQ(gdalName("https://host/a.tif"), "/vsicurl/https://host/a.tif");
    EXPECT_EQ(gdalName("s3://bucket/a.tif"), "/vsis3/bucket/a.tif");
    EXPECT_EQ(gdalName("gs://bucket/a.tif"), "/vsigs/bucket/a.tif");
    for (const char* name : {"a.tif", "/vsizip/a.zip", "/vsis3/b/a.tif", "synthetic:town"}) {
        EXPECT_EQ(gdalName(name), name);
    }
}

TEST(Remote, HttpIsToldFromOtherNetworksAndFromFiles) {
    EXPECT_EQ(httpUrl("/vsicurl/http://host/a"), "http://host/a");
    EXPECT_EQ(httpUrl("http://host/a"), "http://host/a");
    EXPECT_EQ(httpUrl("/vsicurl?url=http://host/a"), "");
    EXPECT_EQ(httpUrl("s3://bucket/a"), "");
    for (const char* name :
         {"http://h/a", "s3://b/a", "/vsigs/b/a", "/vsicurl?url=x", "/vsiaz/b/a"}) {
        EXPECT_TRUE(isRemote(name)) << name;
    }
    for (const char* name :
         {"a.tif", "/vsimem/a", "/vsizip/http.zip", "http", "synthetic:fractal"}) {
        EXPECT_FALSE(isRemote(name)) << name;
    }
}

TEST(Remote, FilesOfAFolderKeepTheKey) {
    EXPECT_EQ(fileIn("a.terray", "b/c"), "a.terray/b/c");
    EXPECT_EQ(fileIn("a.terray/", "b"), "a.terray/b");
    EXPECT_EQ(fileIn("a?b", "c"), "a?b/c");
    EXPECT_EQ(fileIn("http://h/a.terray?k=v/w", "c"), "http://h/a.terray/c?k=v/w");
    EXPECT_EQ(fileIn("/vsicurl/http://h/a/?k", "c"), "/vsicurl/http://h/a/c?k");
}

TEST(Remote, PasswordsAreNotShown) {
    EXPECT_EQ(shownName("http://me:secret@host:80/a@b?key=secret"), "http://host:80/a@b");
    EXPECT_EQ(shownName("/vsicurl/https://token@host/a"), "/vsicurl/https://host/a");
    EXPECT_EQ(shownName("http://me@host"), "http://host");
    EXPECT_EQ(shownName("dir/a?b@c.tif"), "dir/a?b@c.tif");
}

}  // namespace
}  // namespace terray
