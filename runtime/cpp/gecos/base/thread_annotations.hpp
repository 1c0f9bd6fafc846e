#pragma once

/// What clang's -Wthread-safety checks: which mutex guards a member, which one a function needs.
/// Other compilers see nothing. https://clang.llvm.org/docs/ThreadSafetyAnalysis.html
///
/// Lambdas are checked as functions of their own: where one touches guarded members, its first line
/// is `mutex.assert_held();`, or the attribute follows its parameters.
#if defined(__clang__)
#define GECOS_THREAD_ANNOTATION(x) __attribute__((x))
#else
#define GECOS_THREAD_ANNOTATION(x)
#endif

/// A class that is a mutex, or stands for the right to touch something.
#define GECOS_CAPABILITY(name) GECOS_THREAD_ANNOTATION(capability(name))
/// A class that holds one from its constructor to its destructor.
#define GECOS_SCOPED_CAPABILITY GECOS_THREAD_ANNOTATION(scoped_lockable)

/// A member that is read and written with that mutex only.
#define GECOS_GUARDED_BY(mutex) GECOS_THREAD_ANNOTATION(guarded_by(mutex))
/// A pointer whose target is.
#define GECOS_POINTER_GUARDED_BY(mutex) GECOS_THREAD_ANNOTATION(pt_guarded_by(mutex))

/// A function that is called with these mutexes held; and without them.
#define GECOS_REQUIRES(...) GECOS_THREAD_ANNOTATION(requires_capability(__VA_ARGS__))
#define GECOS_EXCLUDES(...) GECOS_THREAD_ANNOTATION(locks_excluded(__VA_ARGS__))

/// Of mutexes and locks themselves.
#define GECOS_ACQUIRE(...) GECOS_THREAD_ANNOTATION(acquire_capability(__VA_ARGS__))
#define GECOS_TRY_ACQUIRE(...) GECOS_THREAD_ANNOTATION(try_acquire_capability(__VA_ARGS__))
#define GECOS_RELEASE(...) GECOS_THREAD_ANNOTATION(release_capability(__VA_ARGS__))
#define GECOS_ASSERT_HELD(...) GECOS_THREAD_ANNOTATION(assert_capability(__VA_ARGS__))

/// A function whose locking the analysis cannot follow; a comment says why it is right.
#define GECOS_NOT_ANALYSED GECOS_THREAD_ANNOTATION(no_thread_safety_analysis)
