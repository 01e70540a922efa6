#if 1 +
#endif
#if 1 / 0
#elif "text"
#else
#else
#endif
#endif
#ifdef
#endif
#if (1
#endif
#if 0
