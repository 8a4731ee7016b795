/* libclsdf_no_network.so, which the wheel's HDF5 has in place of libcurl and libcrypto. Debian's HDF5 links both for
 * one driver, which reads from Amazon's S3 and which clsdf never opens. So the wheel has no network code, and none of
 * the thirty libraries that it stands on. (Debian's static HDF5 has not that need, but is not position-independent.)
 * Every function fails: 2 is curl's CURLE_FAILED_INIT. */
#define FAILS(name)  \
    int name(void);  \
    int name(void) { \
        return 2;    \
    }
#define IS_NULL(name)  \
    void* name(void);  \
    void* name(void) { \
        return 0;      \
    }

FAILS(curl_global_init)
IS_NULL(curl_global_cleanup)
IS_NULL(curl_easy_init)
FAILS(curl_easy_setopt)
FAILS(curl_easy_perform)
IS_NULL(curl_easy_cleanup)
IS_NULL(curl_slist_append)
IS_NULL(curl_slist_free_all)
IS_NULL(EVP_sha256)
IS_NULL(HMAC)
IS_NULL(SHA256)
