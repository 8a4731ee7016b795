/* What the headers of this machine's C and C++ libraries call and those of glibc 2.28 and GCC 8 do not have, by what
 * they do have. packaging/old_glibc.bash links it, hidden, into each program and library of a wheel. */
#include <pthread.h>
#include <time.h>

#pragma GCC visibility push(hidden)

/* Spares atomic operations in programs of one thread. Since glibc 2.32. */
char __libc_single_threaded = 0;

/* std::condition_variable::wait_until. Since glibc 2.30. As libstdc++ did before, by the time that is left. */
int pthread_cond_clockwait(pthread_cond_t* condition, pthread_mutex_t* mutex, clockid_t clock,
                           const struct timespec* until) {
    struct timespec now, time;
    clock_gettime(clock, &now);
    clock_gettime(CLOCK_REALTIME, &time);
    time.tv_sec += until->tv_sec - now.tv_sec;
    time.tv_nsec += until->tv_nsec - now.tv_nsec;
    if (time.tv_nsec >= 1000000000) {
        time.tv_nsec -= 1000000000;
        ++time.tv_sec;
    } else if (time.tv_nsec < 0) {
        time.tv_nsec += 1000000000;
        --time.tv_sec;
    }
    return pthread_cond_timedwait(condition, mutex, &time);
}

/* std::exception_ptr counts its holders by two functions since GCC 11. Its constructor and destructor do both. */
#pragma GCC visibility push(default)
void copy_pointer(void** to, void* const* from) __asm__("_ZNSt15__exception_ptr13exception_ptrC1ERKS0_");
void destroy_pointer(void** pointer) __asm__("_ZNSt15__exception_ptr13exception_ptrD1Ev");
#pragma GCC visibility pop
void add_holder(void** pointer) __asm__("_ZNSt15__exception_ptr13exception_ptr9_M_addrefEv");
void remove_holder(void** pointer) __asm__("_ZNSt15__exception_ptr13exception_ptr10_M_releaseEv");

void add_holder(void** pointer) {
    void* copy = 0;
    copy_pointer(&copy, pointer);
}

void remove_holder(void** pointer) {
    void* copy = *pointer;
    *pointer = 0;
    destroy_pointer(&copy);
}

/* The move of a std::runtime_error, since GCC 9: a copy, which shares the text. */
#pragma GCC visibility push(default)
void copy_error(void* to, const void* from) __asm__("_ZNSt13runtime_errorC2ERKS_");
#pragma GCC visibility pop
void move_error(void* to, void* from) __asm__("_ZNSt13runtime_errorC2EOS_");

void move_error(void* to, void* from) {
    copy_error(to, from);
}

#pragma GCC visibility pop
